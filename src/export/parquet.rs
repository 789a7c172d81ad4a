//! Parquet: the same tables with typed columns, compressed with gzip; the dictionary stands in each file's metadata.
//!
//! Every column is optional: what is empty in CSV is null here. The key `column:NAME` of a file's metadata holds that
//! column's entry of the dictionary as JSON, and `columns.json` has all of them.

use super::Written;
use super::cells::{Cell, Kind, Sink};
use super::columns::{NamedColumn, dictionary};
use super::staging;
use super::tables::{Table, Tables};
use crate::error::LabError;
use ::parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use ::parquet::schema::types::Type;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows that are kept in memory before they are written together.
const GROUP_ROWS: usize = 65_536;

/// Writes the tables into `out`, a folder that must not exist or be empty. Returns the files and their numbers of rows.
///
/// # Errors
/// When `out` holds something already, a session's table cannot be read, or a file cannot be written.
pub fn export(tables: &Tables<'_>, out: &Path) -> Result<Written, LabError> {
    let written = staging::whole(out, |folder| {
        let mut written = Written::new();
        for table in Table::ALL {
            let file = PathBuf::from(format!("{}.parquet", table.name()));
            let mut sink = ParquetTable::create(folder.join(&file), table, &table.columns(&tables.trial_names))?;
            tables.fill(table, &mut sink)?;
            written.push((file, sink.finish()?));
        }
        staging::json(&folder.join("columns.json"), &dictionary(&tables.trial_names, "parquet"))?;
        Ok(written)
    })?;
    Ok(staging::moved(written, out))
}

/// A Parquet file being written.
struct ParquetTable {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
    columns: Vec<Buffer>,
    rows: usize,
}

/// The cells of one column that are not written yet: the values that are there, and for each row whether one is.
struct Buffer {
    present: Vec<i16>,
    values: Values,
}

enum Values {
    Integer(Vec<i64>),
    Real(Vec<f64>),
    Boolean(Vec<bool>),
    Text(Vec<ByteArray>),
}

impl ParquetTable {
    fn create(path: PathBuf, table: Table, columns: &[NamedColumn]) -> Result<Self, LabError> {
        let failed = |error: ParquetError| cannot_write(&path, &error);
        let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let schema = Type::group_type_builder(table.name()).with_fields(fields).build().map_err(failed)?;
        let mut metadata =
            vec![KeyValue::new("parafovea".to_owned(), format!("{} {}", env!("CARGO_PKG_VERSION"), table.name()))];
        for column in columns {
            let entry = serde_json::to_string(column).map_err(|error| LabError::Failed(error.to_string()))?;
            metadata.push(KeyValue::new(format!("column:{}", column.name), entry));
        }
        let properties = WriterProperties::builder()
            .set_compression(Compression::GZIP(Default::default()))
            .set_created_by(concat!("parafovea ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_key_value_metadata(Some(metadata))
            .build();
        let file = File::create_new(&path).map_err(|error| LabError::io("write", &path, &error))?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
        let columns = columns.iter().map(|column| Buffer::new(column.kind)).collect();
        Ok(Self { path, writer, columns, rows: 0 })
    }

    /// Writes what is in memory as one group of rows.
    fn flush(&mut self) -> Result<(), LabError> {
        if self.columns.first().is_none_or(|column| column.present.is_empty()) {
            return Ok(());
        }
        self.write_group().map_err(|error| cannot_write(&self.path, &error))
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for buffer in &mut self.columns {
            if let Some(column) = group.next_column()? {
                buffer.write(column)?;
            }
        }
        group.close()?;
        Ok(())
    }

    fn finish(mut self) -> Result<usize, LabError> {
        self.flush()?;
        self.writer.close().map_err(|error| cannot_write(&self.path, &error))?;
        Ok(self.rows)
    }
}

impl Sink for ParquetTable {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), LabError> {
        for (index, (buffer, cell)) in self.columns.iter_mut().zip(cells).enumerate() {
            buffer.push(cell).map_err(|()| {
                let (path, row) = (self.path.display(), self.rows);
                LabError::Failed(format!("cannot write {path}: column {index} of row {row} holds {cell:?}"))
            })?;
        }
        self.rows += 1;
        if self.rows.is_multiple_of(GROUP_ROWS) { self.flush() } else { Ok(()) }
    }
}

impl Buffer {
    fn new(kind: Kind) -> Self {
        let values = match kind {
            Kind::Integer => Values::Integer(Vec::new()),
            Kind::Real => Values::Real(Vec::new()),
            Kind::Boolean => Values::Boolean(Vec::new()),
            Kind::Text => Values::Text(Vec::new()),
        };
        Self { present: Vec::new(), values }
    }

    /// Takes a cell of the column's own kind or an empty one.
    fn push(&mut self, cell: &Cell<'_>) -> Result<(), ()> {
        match (&mut self.values, cell) {
            (_, Cell::Empty) => {}
            (Values::Integer(values), Cell::Integer(value)) => values.push(*value),
            (Values::Real(values), Cell::Real(value)) => values.push(*value),
            (Values::Boolean(values), Cell::Boolean(value)) => values.push(*value),
            (Values::Text(values), Cell::Text(value)) => values.push(ByteArray::from(value.as_bytes().to_vec())),
            _ => return Err(()),
        }
        self.present.push(i16::from(*cell != Cell::Empty));
        Ok(())
    }

    fn write(&mut self, column: SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let present = std::mem::take(&mut self.present);
        match &mut self.values {
            Values::Integer(values) => write::<Int64Type>(column, values, &present),
            Values::Real(values) => write::<DoubleType>(column, values, &present),
            Values::Boolean(values) => write::<BoolType>(column, values, &present),
            Values::Text(values) => write::<ByteArrayType>(column, values, &present),
        }
    }
}

fn write<T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    values: &mut Vec<T::T>,
    present: &[i16],
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, Some(present), None)?;
    values.clear();
    column.close()
}

fn field(column: &NamedColumn) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Integer => (Physical::INT64, None),
        Kind::Real => (Physical::DOUBLE, None),
        Kind::Boolean => (Physical::BOOLEAN, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
        .map(Arc::new)
}

fn cannot_write(path: &Path, error: &ParquetError) -> LabError {
    LabError::Failed(format!("cannot write {}: {error}", path.display()))
}
