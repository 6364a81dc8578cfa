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
    /// Values that it takes.
    pub shape: Shape,
    /// Range of a number, if it is one.
    pub range: Option<Range>,
    /// Returns its value if none is given, as JSON.
    pub default: fn() -> Value,
    /// `true` if a value has to be given.
    pub is_required: bool,
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
    pub(super) const EMPTY: Self = Self {
        name: "",
        alias: "",
        heading: "",
        text: "",
        shape: f64::SHAPE,
        range: None,
        default: || Value::Null,
        is_required: false,
        value_name: "",
        excludes: &[],
        requires: "",
        is_earlier_name: false,
    };

    /// Returns `true` if this is a name of the option.
    pub(super) fn is_called(&self, name: &str) -> bool {
        [self.name, self.alias].contains(&name)
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
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    text.split("\n\n").map(words)
}

/// Values that an option takes.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Shape {
    /// Kind of a single value.
    pub kind: Kind,
    /// `true` if the option may have no value.
    pub is_optional: bool,
    /// `true` if the option may be given several times.
    pub is_repeated: bool,
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
    /// Another text.
    Text,
}

/// A type of values of options.
pub trait OptionValue: Sized {
    /// The values.
    const SHAPE: Shape;

    /// Parses a word of the command line; `Err` says what is expected.
    ///
    /// # Errors
    /// If the word is no such value.
    fn parse(word: &str) -> Result<Self, String>;

    /// Returns the value for JSON.
    fn json(&self) -> Value;

    /// Makes the value of one of JSON: a number or text, as on the command line.
    ///
    /// # Errors
    /// If there is no such value; the text says what is expected, and what was found.
    fn read(value: &Value) -> Result<Self, String> {
        let word = match value {
            Value::String(text) => text.clone(),
            Value::Number(number) => number.to_string(),
            _ => return Err(format!("expected a number or text, found {value}")),
        };
        Self::parse(&word).map_err(|expected| format!("{expected}, found {word}"))
    }
}

/// Returns the shape of single values that have to be given.
pub(super) const fn shape(kind: Kind) -> Shape {
    Shape {
        kind,
        is_optional: false,
        is_repeated: false,
    }
}

macro_rules! parsed_values {
    ($($Type:ty: $kind:ident, $expected:literal, $is_good:expr;)*) => {
        $(impl OptionValue for $Type {
            const SHAPE: Shape = shape(Kind::$kind);

            fn parse(word: &str) -> Result<Self, String> {
                let value = word.parse().ok().filter($is_good);
                value.ok_or_else(|| concat!("expected ", $expected).into())
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
    const SHAPE: Shape = shape(Kind::Flag);

    fn parse(_: &str) -> Result<Self, String> {
        Err("expected true or false".into())
    }

    fn json(&self) -> Value {
        Value::from(*self)
    }

    fn read(value: &Value) -> Result<Self, String> {
        let expected = || format!("expected true or false, found {value}");
        value.as_bool().ok_or_else(expected)
    }
}

impl OptionValue for PathBuf {
    const SHAPE: Shape = shape(Kind::File);

    fn parse(word: &str) -> Result<Self, String> {
        Ok(word.into())
    }

    fn json(&self) -> Value {
        Value::from(self.to_string_lossy())
    }
}

impl<T: OptionValue> OptionValue for Option<T> {
    const SHAPE: Shape = Shape {
        is_optional: true,
        ..T::SHAPE
    };

    fn parse(word: &str) -> Result<Self, String> {
        T::parse(word).map(Some)
    }

    fn json(&self) -> Value {
        self.as_ref().map_or(Value::Null, T::json)
    }

    fn read(value: &Value) -> Result<Self, String> {
        T::read(value).map(Some)
    }
}

impl<T: OptionValue> OptionValue for Vec<T> {
    const SHAPE: Shape = Shape {
        is_repeated: true,
        ..T::SHAPE
    };

    fn parse(word: &str) -> Result<Self, String> {
        Ok(vec![T::parse(word)?])
    }

    fn json(&self) -> Value {
        self.iter().map(T::json).collect()
    }

    fn read(value: &Value) -> Result<Self, String> {
        match value {
            Value::Array(values) => values.iter().map(T::read).collect(),
            value => Ok(vec![T::read(value)?]),
        }
    }
}

/// A row of a table of the options `R`.
pub struct Row<R: Request> {
    /// The part that users see.
    pub info: OptionInfo,
    pub(super) set: fn(&mut R, &Value) -> Result<(), String>,
    pub(super) json: fn(&R) -> Value,
    /// Applies the option to the options of those who do the work.
    pub(super) apply: fn(&R, &mut R::Options),
}

impl<R: Request> Row<R> {
    /// Returns `true` if the option is not what it is by default.
    pub(super) fn is_given(&self, request: &R) -> bool {
        (self.json)(request) != (self.info.default)()
    }
}

/// A set of options with their table. The sets that it includes come behind its own rows.
pub trait Request: Clone + Default + PartialEq + 'static {
    /// The options in the units of those who do the work.
    type Options;
    /// The rows of its own.
    const TABLE: &'static [Row<Self>];

    /// Returns what users see of all options, in their order.
    #[must_use]
    fn infos() -> Vec<OptionInfo>;

    /// Returns the values of all options by their names, in their order.
    fn values(&self) -> Vec<(&'static str, Value)>;

    /// Returns the options for those who do the work.
    ///
    /// # Errors
    /// If an option is out of its range, or options exclude each other.
    fn options(&self) -> Result<Self::Options, RequestError>;

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
        if self.give(&name, value)? {
            return Ok(());
        }
        Err(RequestError::NoOption(name))
    }

    /// Does what [`set`](Self::set) does, for a name with `_`. Returns `false` if there is no such option.
    ///
    /// # Errors
    /// If the value is of another kind.
    fn give(&mut self, name: &str, value: &Value) -> Result<bool, RequestError>;

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

/// Sets an option of the set's own rows; see [`Request::give`].
pub(super) fn give<R: Request>(
    request: &mut R,
    name: &str,
    value: &Value,
) -> Result<bool, RequestError> {
    let Some(row) = R::TABLE.iter().find(|row| row.info.is_called(name)) else {
        return Ok(false);
    };
    if !value.is_null() {
        let set = (row.set)(request, value);
        set.map_err(|problem| row.info.refused(&problem))?;
    }
    Ok(true)
}

/// Returns the values of the set's own rows.
pub(super) fn values<R: Request>(request: &R) -> impl Iterator<Item = (&'static str, Value)> {
    let rows = R::TABLE.iter().filter(|row| !row.info.is_earlier_name);
    rows.map(|row| (row.info.name, (row.json)(request)))
}

/// Applies the set's own rows to `options`.
pub(super) fn apply<R: Request>(request: &R, options: &mut R::Options) -> Result<(), RequestError> {
    let given = |name: &str| {
        let row = R::TABLE.iter().find(|row| row.info.name == name);
        row.is_some_and(|row| row.is_given(request))
    };
    for row in R::TABLE {
        let info = &row.info;
        if let (Some(range), Some(found)) = (info.range, (row.json)(request).as_f64())
            && !range.contains(found)
        {
            return Err(info.refused(&format!("expected {range}, found {found}")));
        }
        let other = info.excludes.iter().find(|other| given(other));
        if let Some(other) = other.filter(|_| given(info.name)) {
            let option = info.name;
            return Err(RequestError::Excluded { option, other });
        }
        (row.apply)(request, options);
    }
    Ok(())
}

/// Makes a set of options of its table.
///
/// A row has the option's text as documentation, its name, type and default, then what else its [`OptionInfo`] has, and
/// behind `=>` what its value means for the options in the units of those who do the work. Then come sets that are included,
/// as fields.
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

            const TABLE: &'static [table::Row<Self>] = &[$(table::Row {
                info: table::OptionInfo {
                    name: stringify!($name),
                    text: concat!($($text, "\n"),+),
                    shape: <$Type as table::OptionValue>::SHAPE,
                    default: || <$Type as table::OptionValue>::json(&$default),
                    $($key: $value,)*
                    ..table::OptionInfo::EMPTY
                },
                set: |request, value| {
                    request.$name = table::OptionValue::read(value)?;
                    Ok(())
                },
                json: |request| table::OptionValue::json(&request.$name),
                apply: |_request, _options| {
                    $(
                        let apply: fn(&mut $Options, &$Type) = $apply;
                        apply(_options, &_request.$name);
                    )?
                },
            },)*];

            fn infos() -> Vec<table::OptionInfo> {
                let own = Self::TABLE.iter().map(|row| row.info);
                own$($(.chain(<$Inner>::infos()))*)?.collect()
            }

            fn values(&self) -> Vec<(&'static str, serde_json::Value)> {
                table::values(self)$($(.chain(self.$inner.values()))*)?.collect()
            }

            fn give(&mut self, name: &str, value: &serde_json::Value) -> Result<bool, RequestError> {
                let is_own = table::give(self, name, value)?;
                Ok(is_own $($(|| self.$inner.give(name, value)?)*)?)
            }

            fn options(&self) -> Result<$Options, RequestError> {
                let mut options = <$Options>::default();
                table::apply(self, &mut options)?;
                $($(
                    let apply: fn(&mut $Options, <$Inner as table::Request>::Options) = $apply_inner;
                    apply(&mut options, self.$inner.options()?);
                )*)?
                Ok(options)
            }
        }

        impl serde::Serialize for $Request {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_map(table::Request::values(self))
            }
        }
    };
}
pub(super) use options;
