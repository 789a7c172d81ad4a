//! A JSON text and where everything in it stands.
//!
//! The text is read as strict JSON by a parser that keeps positions; this module turns its tree into a map from
//! [`Field`] to bytes, lines and columns, and words its syntax errors. It knows nothing of studies.

use jsonc_parser::ast::Value as Node;
use jsonc_parser::common::Ranged;
use jsonc_parser::errors::{ParseError, ParseErrorKind};
use jsonc_parser::tokens::{Token, TokenAndRange};
use jsonc_parser::{CollectOptions, CommentCollectionStrategy, ParseOptions, parse_to_ast};
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

/// The way from a file's root to one of its values.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(super) struct Field(Vec<Segment>);

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Segment {
    Key(String),
    Item(usize),
}

impl Field {
    /// The file as a whole.
    pub(super) fn root() -> Self {
        Self::default()
    }

    /// A member of the object here.
    pub(super) fn key(&self, name: &str) -> Self {
        self.with(Segment::Key(name.to_owned()))
    }

    /// An element of the list here.
    pub(super) fn item(&self, index: usize) -> Self {
        self.with(Segment::Item(index))
    }

    /// The innermost key: a list's elements answer with the list's.
    pub(super) fn last_key(&self) -> &str {
        let key = self.0.iter().rev().find_map(|segment| match segment {
            Segment::Key(key) => Some(key.as_str()),
            Segment::Item(_) => None,
        });
        key.unwrap_or_default()
    }

    fn with(&self, segment: Segment) -> Self {
        let mut segments = self.0.clone();
        segments.push(segment);
        Self(segments)
    }

    fn parent(&self) -> Option<Self> {
        let (_, parents) = self.0.split_last()?;
        Some(Self(parents.to_vec()))
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Item(item) => write!(f, "[{item}]")?,
                Segment::Key(key) if !is_plain(key) => write!(f, "[{key:?}]")?,
                Segment::Key(key) if index == 0 => write!(f, "{key}")?,
                Segment::Key(key) => write!(f, ".{key}")?,
            }
        }
        Ok(())
    }
}

fn is_plain(key: &str) -> bool {
    !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '$'))
}

/// Where the parts of a text stand.
#[derive(Debug)]
pub(super) struct Source {
    /// Byte at which each line starts.
    line_starts: Vec<usize>,
    text: String,
    places: HashMap<Field, Place>,
}

#[derive(Debug, Clone)]
struct Place {
    key: Option<Range<usize>>,
    value: Range<usize>,
}

impl Source {
    /// A text and, if it could be read, its tree.
    pub(super) fn new(text: &str, root: Option<&Node<'_>>) -> Self {
        let starts = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at + 1);
        let mut source = Self {
            line_starts: std::iter::once(0).chain(starts).collect(),
            text: text.to_owned(),
            places: HashMap::new(),
        };
        if let Some(root) = root {
            source.index_at(root, Field::root(), None);
        }
        source
    }

    /// Notes where a value and everything in it stands. Of keys that occur twice, the first counts.
    fn index_at(&mut self, node: &Node<'_>, field: Field, key: Option<Range<usize>>) {
        if self.places.contains_key(&field) {
            return;
        }
        match node {
            Node::Object(object) => {
                for property in &object.properties {
                    let key = span_of(&property.name);
                    self.index_at(&property.value, field.key(property.name.as_str()), Some(key));
                }
            }
            Node::Array(array) => {
                for (item, element) in array.elements.iter().enumerate() {
                    self.index_at(element, field.item(item), None);
                }
            }
            _ => {}
        }
        self.places.insert(field, Place { key, value: span_of(node) });
    }

    /// Line and column, from 1, of a byte; columns count characters.
    pub(super) fn line_and_column(&self, byte: usize) -> (usize, usize) {
        let byte = byte.min(self.text.len());
        let line = self.line_starts.partition_point(|&start| start <= byte).max(1);
        let start = self.line_starts[line - 1];
        let column = self.text.char_indices().map(|(at, _)| at).skip_while(|&at| at < start);
        (line, column.take_while(|&at| at < byte).count() + 1)
    }

    /// The bytes of a field's value; of a field that is not there, the place of what should hold it.
    pub(super) fn value_span(&self, field: &Field) -> Range<usize> {
        match self.places.get(field) {
            Some(place) => place.value.clone(),
            None => self.holder_span(field),
        }
    }

    /// The bytes of a field's key.
    pub(super) fn key_span(&self, field: &Field) -> Range<usize> {
        match self.places.get(field) {
            Some(Place { key: Some(key), .. }) => key.clone(),
            Some(Place { key: None, value }) => first_char(&self.text, value),
            None => self.holder_span(field),
        }
    }

    fn holder_span(&self, field: &Field) -> Range<usize> {
        field.parent().map_or(0..0, |parent| self.key_span(&parent))
    }
}

fn first_char(text: &str, span: &Range<usize>) -> Range<usize> {
    let length = text.get(span.clone()).and_then(|s| s.chars().next()).map_or(0, char::len_utf8);
    span.start..span.start + length
}

pub(super) fn span_of(node: &impl Ranged) -> Range<usize> {
    node.start()..node.end()
}

/// What is wrong with a text as JSON: the bytes at fault and the message.
pub(super) type SyntaxMistake = (Range<usize>, String);

/// Reads a text as strict JSON. Comments and trailing commas are reported without stopping; any other syntax error is
/// the last thing that can be said, and no tree comes back.
pub(super) fn parse(text: &str) -> (Option<Node<'_>>, Vec<SyntaxMistake>) {
    let collect = CollectOptions { comments: CommentCollectionStrategy::AsTokens, tokens: true };
    let options = ParseOptions {
        allow_comments: true,
        allow_trailing_commas: true,
        allow_loose_object_property_names: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    match parse_to_ast(text, &collect, &options) {
        Err(error) => {
            let range = error.range();
            let here = (range.start..range.end.max(range.start), syntax_message(text, &error));
            // A string that is not closed runs on into the next lines before this parser stumbles.
            let earlier =
                strictly(text).filter(|(span, _)| text.get(span.start..here.0.start).is_some_and(|t| t.contains('\n')));
            (None, vec![earlier.unwrap_or(here)])
        }
        Ok(parsed) => {
            let mut mistakes = leniencies(parsed.tokens.as_deref().unwrap_or_default());
            if parsed.value.is_none() {
                mistakes.push((0..0, "expected a JSON object, found nothing: the file is empty".to_owned()));
            }
            (parsed.value, mistakes)
        }
    }
}

/// The first thing in a text that strict JSON forbids, as a second parser sees it: what the first lets pass (raw line
/// breaks in strings, leading zeros) must not become a study that other programs cannot read.
pub(super) fn strictly(text: &str) -> Option<SyntaxMistake> {
    let error = serde_json::from_str::<serde::de::IgnoredAny>(text).err()?;
    let line_start = match error.line().saturating_sub(1) {
        0 => 0,
        line => text.match_indices('\n').nth(line - 1).map_or(text.len(), |(at, _)| at + 1),
    };
    let at = text.floor_char_boundary((line_start + error.column().saturating_sub(1)).min(text.len()));
    let message = error.to_string();
    let (reason, _) = message.rsplit_once(" at line ").unwrap_or((&message, ""));
    let message = match reason.starts_with("control character") {
        true => "expected the closing quote of a string on its line, found a line break or another control character"
            .to_owned(),
        false => format!("expected strict JSON: {reason}"),
    };
    Some((at..at, message))
}

/// Comments and trailing commas: the parser lets them pass, JSON does not.
fn leniencies(tokens: &[TokenAndRange<'_>]) -> Vec<SyntaxMistake> {
    let mut mistakes = Vec::new();
    let mut comma: Option<Range<usize>> = None;
    for token in tokens {
        let span = token.range.start..token.range.end;
        match &token.token {
            Token::CommentLine(_) | Token::CommentBlock(_) => {
                mistakes.push((span, "expected JSON without comments, found a comment".to_owned()));
            }
            Token::Comma => comma = Some(span),
            Token::CloseBrace | Token::CloseBracket => {
                if let Some(comma) = comma.take() {
                    mistakes.push((comma, "expected no comma after the last entry, found one".to_owned()));
                }
            }
            _ => comma = None,
        }
    }
    mistakes
}

fn syntax_message(text: &str, error: &ParseError) -> String {
    let expected = match error.kind() {
        ParseErrorKind::ExpectedComma => "a comma between two entries",
        ParseErrorKind::ExpectedColonAfterObjectKey => "a colon after the key",
        ParseErrorKind::ExpectedObjectValue => "a value after the colon",
        ParseErrorKind::ExpectedStringObjectProperty => "a key in double quotes",
        ParseErrorKind::UnexpectedTokenInObject => "a key in double quotes or a closing brace",
        ParseErrorKind::SingleQuotedStringsNotAllowed => "double quotes",
        ParseErrorKind::UnterminatedObject => "a closing brace for the object that opens here",
        ParseErrorKind::UnterminatedArray => "a closing bracket for the list that opens here",
        ParseErrorKind::MultipleRootJsonValues => "the end of the file after the first value",
        ParseErrorKind::NestingDepthExceeded => "fewer levels of nesting",
        ParseErrorKind::NonFiniteNumbersNotAllowed => "a finite number",
        ParseErrorKind::BareDecimalPointNumbersNotAllowed => "digits on both sides of the decimal point",
        ParseErrorKind::ExpectedDigit
        | ParseErrorKind::ExpectedDigitFollowingNegativeSign
        | ParseErrorKind::ExpectedPlusMinusOrDigitInNumberLiteral
        | ParseErrorKind::HexadecimalNumbersNotAllowed
        | ParseErrorKind::UnaryPlusNumbersNotAllowed => "a decimal number",
        ParseErrorKind::UnexpectedCloseBrace
        | ParseErrorKind::UnexpectedCloseBracket
        | ParseErrorKind::UnexpectedColon
        | ParseErrorKind::UnexpectedComma
        | ParseErrorKind::UnexpectedToken
        | ParseErrorKind::UnexpectedWord => {
            "a value: a string in double quotes, a number, true, false, a list or an object"
        }
        other => return format!("expected JSON: {}", lower_first(&other.to_string())),
    };
    let range = error.range();
    let found = text.get(range.start..range.end).unwrap_or_default().trim();
    match (found.is_empty(), found.chars().count()) {
        (true, _) => format!("expected {expected}"),
        (false, 0..=24) => format!("expected {expected}, found {found}"),
        (false, _) => format!("expected {expected}, found {}…", found.chars().take(24).collect::<String>()),
    }
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}
