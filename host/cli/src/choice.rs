//! Parses values that have names in the library, with their help.

use core::marker::PhantomData;
use std::ffi::OsStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, Command, Error};

use foldpath::request::{Named, value_of};

/// Parser of the names of `T`.
pub(crate) struct Choice<T>(PhantomData<fn() -> T>);

impl<T> Clone for Choice<T> {
    fn clone(&self) -> Self {
        Self(PhantomData)
    }
}

/// Returns a parser of the names of `T`.
pub(crate) fn choice<T: Named + Send + Sync>() -> Choice<T> {
    Choice(PhantomData)
}

/// Returns the names with their help.
fn names<T: Named>() -> impl Iterator<Item = PossibleValue> {
    T::NAMES.iter().map(|(name, _, help)| {
        let value = PossibleValue::new(*name);
        if help.is_empty() {
            value
        } else {
            value.help(*help)
        }
    })
}

impl<T: Named + Send + Sync> TypedValueParser for Choice<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let parser = PossibleValuesParser::new(names::<T>());
        let name = parser.parse_ref(command, argument, value)?;
        value_of(&name).ok_or_else(|| Error::new(clap::error::ErrorKind::InvalidValue))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(names::<T>()))
    }
}
