//! Makes clap's arguments of the library's tables of options.

use core::fmt::Display;
use std::path::PathBuf;

use clap::builder::{
    NonEmptyStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser,
};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{
    Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, Subcommand, ValueHint,
    value_parser,
};
use foldpath::export::{FORMATS, Format};
use foldpath::request::{FAMILIES, Kind, OptionInfo, Request, RequestError, paragraphs};
use serde_json::{Map, Value};

/// The options `R` as arguments of a command. A value that an option cannot have is told as everywhere else, and not in the
/// words of clap.
#[derive(Clone, Debug)]
pub(crate) struct Options<R>(Result<R, RequestError>);

impl<R> Options<R> {
    /// Returns the options.
    ///
    /// # Errors
    /// If an option has a value that it cannot have.
    pub(crate) fn get(&self) -> Result<&R, RequestError> {
        self.0.as_ref().map_err(Clone::clone)
    }
}

impl<R: Request> Args for Options<R> {
    fn augment_args(command: Command) -> Command {
        command.args(R::infos().iter().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<R: Request> FromArgMatches for Options<R> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let given = given(matches, &R::infos()).collect();
        Ok(Self(R::of(&given)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// A family of patterns with its parameters as a subcommand, and the file to write.
#[derive(Clone, Debug)]
pub(crate) struct FamilyArgs {
    pub(crate) family: Map<String, Value>,
    pub(crate) output: PathBuf,
}

impl Subcommand for FamilyArgs {
    fn augment_subcommands(command: Command) -> Command {
        let output = || {
            let output = Arg::new("output")
                .short('o')
                .long("output")
                .value_name("OUTPUT");
            output
                .help("File to write")
                .value_parser(value_parser!(PathBuf))
                .required(true)
        };
        command
            .subcommand_required(true)
            .arg_required_else_help(true)
            .subcommands(FAMILIES.iter().map(|info| {
                let (about, long) = texts(info.text);
                let mut family = Command::new(info.name).about(about);
                if let Some(long) = long {
                    family = family.long_about(long);
                }
                let known = info.examples.iter();
                let known = known.map(|example| format!("generate {} {example}", info.name));
                // The file stands behind the size of the sheet, and before what has a default.
                let (size, others) = info.parameters.split_at(2);
                family
                    .args(size.iter().map(argument))
                    .arg(output())
                    .args(others.iter().map(argument))
                    .after_help(examples(known))
            }))
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        FAMILIES.iter().any(|info| info.name == name)
    }
}

impl FromArgMatches for FamilyArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let missing = || Error::new(ErrorKind::MissingSubcommand);
        let (name, matches) = matches.subcommand().ok_or_else(missing)?;
        let known = FAMILIES.iter().find(|info| info.name == name);
        let known = known.ok_or_else(missing)?;
        let mut family: Map<String, Value> = given(matches, known.parameters).collect();
        family.insert("family".into(), name.into());
        let output = matches.get_one("output").cloned().unwrap_or_default();
        Ok(Self { family, output })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Returns the text of an error, in which options are named as on the command line.
pub(crate) fn on_command_line(error: &RequestError) -> String {
    let flag = |option: &str| format!("--{}", option.replace('_', "-"));
    match error {
        RequestError::Option {
            option, problem, ..
        } => format!("{}: {problem}", flag(option)),
        RequestError::Excluded { option, other } => {
            format!("{}: expected without {}", flag(option), flag(other))
        }
        RequestError::NoOption(name) => format!("unexpected argument '{}' found", flag(name)),
        error => error.to_string(),
    }
}

/// Returns the part of a help text with examples.
pub(crate) fn examples(arguments: impl IntoIterator<Item: Display>) -> String {
    let examples = arguments
        .into_iter()
        .map(|arguments| format!("\n  foldpath {arguments}"));
    format!("Examples:{}", examples.collect::<String>())
}

/// Returns a parser of the names of formats.
pub(crate) fn formats() -> impl TypedValueParser<Value = &'static Format> {
    let names = FORMATS
        .iter()
        .map(|format| PossibleValue::new(format.name).help(format.text));
    PossibleValuesParser::new(names).try_map(|name| Format::named(&name).ok_or("expected a format"))
}

/// Returns the first paragraph of a text, and the whole text if there are more.
fn texts(text: &str) -> (String, Option<String>) {
    let all: Vec<String> = paragraphs(text).collect();
    let long = (all.len() > 1).then(|| all.join("\n\n"));
    (all.into_iter().next().unwrap_or_default(), long)
}

/// Returns the options that the command line gives, with their values as JSON.
fn given(matches: &ArgMatches, infos: &[OptionInfo]) -> impl Iterator<Item = (String, Value)> {
    let given = infos
        .iter()
        .filter(|info| matches.value_source(info.name) == Some(ValueSource::CommandLine));
    given.map(|info| {
        let words = matches.get_raw(info.name).into_iter().flatten();
        let mut words = words.map(|word| Value::from(word.to_string_lossy()));
        let value = match (info.kind, info.is_repeated) {
            (Kind::Flag, _) => Value::Bool(true),
            (_, true) => words.collect(),
            (_, false) => words.next().unwrap_or_default(),
        };
        (info.name.into(), value)
    })
}

/// Returns a default value as the help shows it; `None` for a default that means nothing is given.
fn shown(default: &Value) -> Option<String> {
    match default {
        Value::String(text) => Some(text.clone()),
        // Without the fraction that JSON gives to whole numbers.
        Value::Number(number) => Some(number.as_f64()?.to_string()),
        _ => None,
    }
}

/// Returns the argument of an option.
fn argument(info: &OptionInfo) -> Arg {
    let (first, long) = texts(info.text);
    let name = match info.value_name {
        "" => info.name.to_uppercase(),
        name => name.into(),
    };
    let mut argument = Arg::new(info.name)
        .long(info.flag())
        .conflicts_with_all(info.excludes)
        .hide(info.is_earlier_name)
        .required(info.is_required());
    if !info.alias.is_empty() {
        argument = argument.alias(info.alias);
    }
    if !info.heading.is_empty() {
        argument = argument.help_heading(info.heading);
    }
    if !info.requires.is_empty() {
        argument = argument.requires(info.requires);
    }
    if let Some(long) = long {
        argument = argument.long_help(long);
    }
    if let Some(default) = shown(&(info.default)()).filter(|_| !info.is_earlier_name) {
        argument = argument.default_value(default);
    }
    let argument = match info.kind {
        Kind::Flag => return argument.help(first).action(ArgAction::SetTrue),
        Kind::File => argument
            .value_parser(NonEmptyStringValueParser::new())
            .value_hint(ValueHint::AnyPath),
        Kind::Names(names) => argument.value_parser(PossibleValuesParser::new(names.iter().map(
            |&(name, help)| match help {
                "" => PossibleValue::new(name),
                _ => PossibleValue::new(name).help(help),
            },
        ))),
        _ => argument,
    };
    let action = if info.is_repeated {
        ArgAction::Append
    } else {
        ArgAction::Set
    };
    argument.help(first).value_name(name).action(action)
}
