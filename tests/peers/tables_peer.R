# CSV and BIDS exports read with base R (and jsonlite for the dictionaries).
#
#     Rscript tables_peer.R /tmp/kept/tables-csv /tmp/kept/bids-binocular
#
# Checks that read.csv finds the columns of columns.json, that numbers are read as numbers and levels are the ones described, and
# that read.delim reads every table of the BIDS data set, compressed or not, with n/a as missing.

suppressPackageStartupMessages(library(jsonlite))
arguments <- commandArgs(trailingOnly = TRUE)
cat(sprintf("%s, jsonlite %s\n", R.version.string, packageVersion("jsonlite")))

dictionary <- read_json(file.path(arguments[1], "columns.json"))
rows <- 0
for (file in names(dictionary)) {
  described <- dictionary[[file]]
  names_there <- vapply(described, function(column) column$name, "")
  kinds <- vapply(described, function(column) column$type, "")
  classes <- ifelse(kinds == "text", "character", NA)
  table <- read.csv(file.path(arguments[1], file), check.names = FALSE, colClasses = classes, na.strings = "")
  stopifnot(identical(names(table), names_there))
  for (index in seq_along(described)) {
    values <- table[[index]]
    if (kinds[index] != "text") stopifnot(is.numeric(values) || all(is.na(values)))
    if (kinds[index] == "boolean") stopifnot(all(values %in% c(0, 1, NA)))
    levels <- names(described[[index]]$levels)
    if (length(levels) > 0) stopifnot(all(as.character(values[!is.na(values)]) %in% levels))
  }
  rows <- rows + nrow(table)
}
cat(sprintf("CSV: %d tables, %d rows\n", length(dictionary), rows))

files <- list.files(arguments[2], "\\.tsv(\\.gz)?$", recursive = TRUE, full.names = TRUE)
rows <- 0
for (file in files) {
  sidecar <- read_json(sub("\\.tsv(\\.gz)?$", ".json", file))
  columns <- unlist(sidecar$Columns)
  compressed <- grepl("gz$", file)
  table <- read.delim(if (compressed) gzfile(file) else file, header = !compressed, na.strings = "n/a", quote = "", check.names = FALSE)
  if (compressed) {
    stopifnot(ncol(table) == length(columns))
    names(table) <- columns
  }
  stopifnot(all(names(table) %in% names(sidecar)))
  for (column in intersect(names(table), c("onset", "duration", "timestamp", "x_coordinate", "y_coordinate", "pupil_size"))) {
    stopifnot(is.numeric(table[[column]]) || all(is.na(table[[column]])))
  }
  rows <- rows + nrow(table)
}
cat(sprintf("BIDS: %d tables, %d rows\n", length(files), rows))
