//! The form of a table of options; [`options`](super::options) has the tables.
//!
//! The macro `options!` makes of a table the struct of the options with its default, each option by its name, and an
//! [`OptionInfo`] for each. Clap's arguments, the JSON Schema, the Python signature and the documents are made of these.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::error::RequestError;
use crate::util::range::Range;

/// The part of a row that users of the option see.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct OptionInfo {
    /// Name, with `_` between its words.
    pub name: &'static str,
    /// Another name for it; empty for none.
    pub alias: &'static str,
    /// Heading under which lists show it; empty for none.
    pub heading: &'static str,
    /// The first paragraph says what it is.
    pub text: &'static str,
    /// Kind of a single value.
    pub kind: Kind,
    /// `true` if the option may have no value.
    pub is_optional: bool,
    /// `true` if the option may be given several times.
    pub is_repeated: bool,
    /// Range of a number, if it is one.
    pub range: Option<Range>,
    /// Returns its value if none is given, as JSON.
    pub default: fn() -> Value,
    /// Name of its value in the help; empty for its own name.
    pub value_name: &'static str,
    /// Options that cannot be given beside it.
    pub excludes: &'static [&'static str],
    /// Argument of the command without which it means nothing; empty for none.
    pub requires: &'static str,
    /// `true` for an earlier name of another option, which lists leave out.
    pub is_earlier_name: bool,
}

impl OptionInfo {
    /// An option without a default: it has to be given.
    pub(super) const fn new(name: &'static str, kind: Kind) -> Self {
        Self {
            name,
            alias: "",
            heading: "",
            text: "",
            kind,
            is_optional: false,
            is_repeated: false,
            range: None,
            default: || Value::Null,
            value_name: "",
            excludes: &[],
            requires: "",
            is_earlier_name: false,
        }
    }

    /// Returns `true` if a value has to be given.
    #[must_use]
    pub fn is_required(&self) -> bool {
        !self.is_optional && (self.default)().is_null()
    }

    /// Returns the name on the command line, without the dashes before it.
    #[must_use]
    pub fn flag(&self) -> String {
        self.name.replace('_', "-")
    }

    pub(super) fn refused(&self, problem: &str) -> RequestError {
        RequestError::option(self.name, problem)
    }
}

/// Returns the paragraphs of a text, each in one line.
pub fn paragraphs(text: &str) -> impl Iterator<Item = String> {
    let one_line = |text: &str| {
        let mut line = String::with_capacity(text.len());
        for part in text.lines().map(str::trim).filter(|part| !part.is_empty()) {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(part);
        }
        line
    };
    text.split("\n\n").map(one_line)
}

/// Kind of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// A finite number.
    Number,
    /// A whole number from 0.
    Count,
    /// Given or not.
    Flag,
    /// One of these names, each with what it means; no meaning if the name says it.
    Names(&'static [(&'static str, &'static str)]),
    /// The name of a file.
    File,
    /// A text such as `4=-45`: an edge with an angle.
    EdgeAngle,
    /// A text such as `7=-30..60`: an edge with a range of angles.
    EdgeRange,
    /// A finite number, or a name in its place.
    NumberOrName,
    /// Another text.
    Text,
}

/// A type of values of options.
pub(super) trait OptionValue: Sized {
    /// Kind of a single value.
    const KIND: Kind;
    /// `true` if there may be none.
    const IS_OPTIONAL: bool = false;
    /// `true` if there may be several.
    const IS_REPEATED: bool = false;

    /// Makes the value of one of JSON: a number or text, as on the command line. `Err` says what is expected, and what was
    /// found.
    fn read(value: &Value) -> Result<Self, String>;

    /// Returns the value for JSON.
    fn json(&self) -> Value;
}

/// Reads a number or text of JSON as a word of the command line.
pub(super) fn word<T>(
    value: &Value,
    expected: &str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<T, String> {
    let word = match value {
        Value::String(text) => text.clone(),
        Value::Number(number) => number.to_string(),
        _ => return Err(format!("expected a number or text, found {value}")),
    };
    parse(&word).ok_or_else(|| format!("expected {expected}, found {word}"))
}

macro_rules! parsed_values {
    ($($Type:ty: $kind:ident, $expected:literal, $is_good:expr;)*) => {
        $(impl OptionValue for $Type {
            const KIND: Kind = Kind::$kind;

            fn read(value: &Value) -> Result<Self, String> {
                word(value, $expected, |word| word.parse().ok().filter($is_good))
            }

            fn json(&self) -> Value {
                Value::from(*self)
            }
        })*
    };
}

parsed_values! {
    f64: Number, "a finite number", |number: &f64| number.is_finite();
    u64: Count, "a whole number from 0", |_| true;
    usize: Count, "a whole number from 0", |_| true;
}

impl OptionValue for bool {
    const KIND: Kind = Kind::Flag;

    fn read(value: &Value) -> Result<Self, String> {
        let expected = || format!("expected true or false, found {value}");
        value.as_bool().ok_or_else(expected)
    }

    fn json(&self) -> Value {
        Value::from(*self)
    }
}

impl OptionValue for PathBuf {
    const KIND: Kind = Kind::File;

    fn read(value: &Value) -> Result<Self, String> {
        word(value, "a file", |word| Some(word.into()))
    }

    fn json(&self) -> Value {
        Value::from(self.to_string_lossy())
    }
}

impl<T: OptionValue> OptionValue for Option<T> {
    const KIND: Kind = T::KIND;
    const IS_OPTIONAL: bool = true;

    fn read(value: &Value) -> Result<Self, String> {
        T::read(value).map(Some)
    }

    fn json(&self) -> Value {
        self.as_ref().map_or(Value::Null, T::json)
    }
}

impl<T: OptionValue> OptionValue for Vec<T> {
    const KIND: Kind = T::KIND;
    const IS_REPEATED: bool = true;

    fn read(value: &Value) -> Result<Self, String> {
        match value {
            Value::Array(values) => values.iter().map(T::read).collect(),
            value => Ok(vec![T::read(value)?]),
        }
    }

    fn json(&self) -> Value {
        self.iter().map(T::json).collect()
    }
}

/// A set of options, made of its table. The sets that it includes come behind its own options.
pub trait Request: Clone + Default + PartialEq + 'static {
    /// The options in the units of those who do the work.
    type Options: Default;

    /// Returns what users see of all options, with their values, in their order.
    fn rows(&self) -> Vec<(OptionInfo, Value)>;

    /// Does what [`set`](Self::set) does, for a name with `_`. Returns `false` if there is no such option.
    ///
    /// # Errors
    /// If the value is of another kind.
    fn give(&mut self, name: &str, value: &Value) -> Result<bool, String>;

    /// Applies the options to the options of those who do the work.
    fn apply(&self, options: &mut Self::Options);

    /// Returns what users see of all options, in their order.
    #[must_use]
    fn infos() -> Vec<OptionInfo> {
        let rows = Self::default().rows().into_iter();
        rows.map(|(info, _)| info).collect()
    }

    /// Returns the options that are not what they are by default.
    fn given(&self) -> Vec<(OptionInfo, Value)> {
        let mut rows = self.rows();
        rows.retain(|(info, value)| *value != (info.default)());
        rows
    }

    /// Returns the options for those who do the work.
    ///
    /// # Errors
    /// If an option is out of its range, or options exclude each other.
    fn options(&self) -> Result<Self::Options, RequestError> {
        let given = self.given();
        for (info, value) in &given {
            if let (Some(range), Some(found)) = (info.range, value.as_f64())
                && !range.contains(found)
            {
                return Err(info.refused(&format!("expected {range}, found {found}")));
            }
            let is_given = |other: &&&str| given.iter().any(|(info, _)| info.name == **other);
            if let Some(other) = info.excludes.iter().find(is_given) {
                let option = info.name;
                return Err(RequestError::Excluded { option, other });
            }
        }
        let mut options = Self::Options::default();
        self.apply(&mut options);
        Ok(options)
    }

    /// Sets the option `name`, with `_` or `-` between its words.
    ///
    /// A value is a number or text, as on the command line. A list stands for an option that may be given several times,
    /// and replaces what the option was. An option without a value, such as `keep`, is `true` or `false`. With `null` the
    /// option stays as it is.
    ///
    /// # Errors
    /// If there is no such option, or the value is of another kind. Ranges are judged by [`options`](Self::options).
    fn set(&mut self, name: &str, value: &Value) -> Result<(), RequestError> {
        let name = name.replace('-', "_");
        match self.give(&name, value) {
            Ok(true) => Ok(()),
            Ok(false) => Err(RequestError::NoOption(name)),
            Err(problem) => Err(RequestError::option(&name, problem)),
        }
    }

    /// Returns the default options with those of a JSON object set.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    fn of(given: &Map<String, Value>) -> Result<Self, RequestError> {
        let mut request = Self::default();
        for (name, value) in given {
            request.set(name, value)?;
        }
        Ok(request)
    }
}

/// Makes a set of options of its table.
///
/// A row has the option's text as documentation, its name, type and default, then what else its [`OptionInfo`] has, and
/// behind `=>` what its value means for the options in the units of those who do the work; without `=>` it is their field of
/// the same name. Then come sets that are included, as fields.
macro_rules! options {
    (
        $(#[$about:meta])*
        $Request:ident for $Options:ty {
            $(
                $(#[doc = $text:literal])+
                $name:ident: $Type:ty = $default:expr $(, $key:ident: $value:expr)* $(=> $apply:expr)?;
            )*
        }
        $(includes {$(
            $(#[doc = $inner_text:literal])+
            $inner:ident: $Inner:ty => $apply_inner:expr;
        )*})?
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $Request {
            $($(#[doc = $text])+ pub $name: $Type,)*
            $($($(#[doc = $inner_text])+ pub $inner: $Inner,)*)?
        }

        impl Default for $Request {
            fn default() -> Self {
                Self {
                    $($name: $default,)*
                    $($($inner: <$Inner>::default(),)*)?
                }
            }
        }

        impl table::Request for $Request {
            type Options = $Options;

            fn rows(&self) -> Vec<(table::OptionInfo, serde_json::Value)> {
                let own = [$((
                    table::OptionInfo {
                        text: concat!($($text, "\n"),+),
                        is_optional: <$Type as table::OptionValue>::IS_OPTIONAL,
                        is_repeated: <$Type as table::OptionValue>::IS_REPEATED,
                        default: || <$Type as table::OptionValue>::json(&$default),
                        $($key: $value,)*
                        ..table::OptionInfo::new(stringify!($name), <$Type as table::OptionValue>::KIND)
                    },
                    table::OptionValue::json(&self.$name),
                )),*];
                own.into_iter()$($(.chain(self.$inner.rows()))*)?.collect()
            }

            fn give(&mut self, name: &str, value: &serde_json::Value) -> Result<bool, String> {
                match name {
                    $(stringify!($name) if value.is_null() => {}
                    stringify!($name) => self.$name = table::OptionValue::read(value)?,)*
                    _ => return Ok(false $($(|| self.$inner.give(name, value)?)*)?),
                }
                Ok(true)
            }

            fn apply(&self, options: &mut $Options) {
                $(table::options!(@apply options, $name, &self.$name, $Options, $Type $(, $apply)?);)*
                $($(
                    let apply: fn(&mut $Options, <$Inner as table::Request>::Options) = $apply_inner;
                    let mut inner = Default::default();
                    self.$inner.apply(&mut inner);
                    apply(options, inner);
                )*)?
            }
        }

        impl serde::Serialize for $Request {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let rows = table::Request::rows(self).into_iter().filter(|(info, _)| !info.is_earlier_name);
                serializer.collect_map(rows.map(|(info, value)| (info.name, value)))
            }
        }
    };
    (@apply $options:ident, $name:ident, $value:expr, $Options:ty, $Type:ty) => {
        $options.$name.clone_from($value);
    };
    (@apply $options:ident, $name:ident, $value:expr, $Options:ty, $Type:ty, $apply:expr) => {
        let apply: fn(&mut $Options, &$Type) = $apply;
        apply($options, $value);
    };
}
pub(super) use options;
