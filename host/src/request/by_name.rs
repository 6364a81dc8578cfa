//! Sets options by their names, from the values of JSON.

use core::fmt::Display;
use core::str::FromStr;
use std::path::PathBuf;

use serde_json::Value;

use super::check::CheckRequest;
use super::error::RequestError;
use super::names::{Named, value_of};
use super::options::{PlanRequest, ReadingRequest};
use crate::planner::{Symmetry, Vertices};

impl PlanRequest {
    /// Sets the option `name`, with `_` or `-` between its words.
    ///
    /// A value is a number or text, as on the command line. A list stands for an option that may be given several times,
    /// and replaces what the option was. `keep` is `true` or `false`. With `null` the option stays as it is.
    ///
    /// # Errors
    /// If there is no such option, or the value is of another kind. Ranges are judged by [`options`](Self::options).
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), RequestError> {
        let Some(given) = Given::of(name, value) else {
            return Ok(());
        };
        match &*given.name {
            "goal" => self.goal = Some(PathBuf::from(given.text()?)),
            "fold" => self.fold = Some(given.number()?),
            "crease" => self.crease = given.each()?,
            "via" => self.via = given.texts()?.into_iter().map(PathBuf::from).collect(),
            "goal_tolerance" => self.goal_tolerance = given.number()?,
            "limit" => self.limit = given.each()?,
            "bound" => self.bound = given.number()?,
            "bend" => self.bend = given.number()?,
            "keep" => self.keep = given.yes()?,
            "contact" => self.contact = Some(given.number()?),
            "symmetry" => self.symmetry = given.named()?,
            "vertices" => self.vertices = given.named()?,
            "reuse" => {
                // The name of this option before there was `vertices`.
                self.vertices = match given.named()? {
                    Symmetry::Auto => Vertices::Essential,
                    Symmetry::Off => Vertices::All,
                }
            }
            "collision" => self.collision = given.named()?,
            "interpolation" => self.interpolation = given.named()?,
            "max_speed" => self.max_speed = given.number()?,
            "max_accel" => self.max_accel = Some(given.number()?),
            "pace" => self.pace = given.named()?,
            "max_knots" => self.max_knots = Some(given.count()?),
            "frames" => self.frames = given.named()?,
            "solver" => self.solver = given.named()?,
            "search" => self.search = given.named()?,
            "objective" => self.objective = given.named()?,
            "seed" => self.seed = given.count()?,
            "timeout" => self.timeout = Some(given.number()?),
            _ => return self.reading.set_given(&given),
        }
        Ok(())
    }
}

impl CheckRequest {
    /// Sets the option `name`; see [`PlanRequest::set`].
    ///
    /// # Errors
    /// As [`PlanRequest::set`].
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), RequestError> {
        let Some(given) = Given::of(name, value) else {
            return Ok(());
        };
        match &*given.name {
            "bound" => self.bound = given.number()?,
            "bend" => self.bend = given.number()?,
            "contact" => self.contact = Some(given.number()?),
            _ => return Err(given.unexpected()),
        }
        Ok(())
    }
}

impl ReadingRequest {
    /// Sets the option `name`; see [`PlanRequest::set`].
    ///
    /// # Errors
    /// As [`PlanRequest::set`].
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), RequestError> {
        Given::of(name, value).map_or(Ok(()), |given| self.set_given(&given))
    }

    fn set_given(&mut self, given: &Given<'_>) -> Result<(), RequestError> {
        match &*given.name {
            "tolerance" => self.tolerance = Some(given.number()?),
            "straighten" => self.straighten = given.named()?,
            "colors" => {
                let letters = given.text()?.parse();
                let flag = given.flag();
                let letters =
                    letters.map_err(|error| RequestError::Usage(format!("{flag}: {error}")))?;
                self.colors = Some(letters);
            }
            _ => return Err(given.unexpected()),
        }
        Ok(())
    }
}

/// An option's name and value.
struct Given<'a> {
    /// With `_` between its words.
    name: String,
    value: &'a Value,
}

impl<'a> Given<'a> {
    /// Returns the option, unless its value is `null`.
    fn of(name: &str, value: &'a Value) -> Option<Self> {
        let name = name.replace('-', "_");
        (!value.is_null()).then_some(Self { name, value })
    }

    /// Returns the name on the command line.
    fn flag(&self) -> String {
        format!("--{}", self.name.replace('_', "-"))
    }

    fn unexpected(&self) -> RequestError {
        RequestError::Usage(format!("unexpected argument '{}' found", self.flag()))
    }

    fn expected<T>(&self, expected: impl Display, found: impl Display) -> Result<T, RequestError> {
        let flag = self.flag();
        Err(RequestError::Usage(format!(
            "{flag}: expected {expected}, found {found}"
        )))
    }

    fn text_of(&self, value: &Value) -> Result<String, RequestError> {
        match value {
            Value::String(text) => Ok(text.clone()),
            Value::Number(number) => Ok(number.to_string()),
            _ => self.expected("a number or text", value),
        }
    }

    fn text(&self) -> Result<String, RequestError> {
        self.text_of(self.value)
    }

    /// Returns the texts of an option that may be given several times.
    fn texts(&self) -> Result<Vec<String>, RequestError> {
        match self.value {
            Value::Array(values) => values.iter().map(|value| self.text_of(value)).collect(),
            value => Ok(vec![self.text_of(value)?]),
        }
    }

    fn number(&self) -> Result<f64, RequestError> {
        let text = self.text()?;
        let number = text.parse();
        number.or_else(|_| self.expected("a number", &text))
    }

    fn count<T: FromStr>(&self) -> Result<T, RequestError> {
        let text = self.text()?;
        let count = text.parse();
        count.or_else(|_| self.expected("a whole number from 0", &text))
    }

    fn yes(&self) -> Result<bool, RequestError> {
        match self.value {
            Value::Bool(yes) => Ok(*yes),
            value => self.expected("true or false", value),
        }
    }

    /// Parses values whose errors say what was expected.
    fn each<T: FromStr<Err: Display>>(&self) -> Result<Vec<T>, RequestError> {
        let flag = self.flag();
        let parsed = |text: String| {
            let value = text.parse::<T>();
            value.map_err(|error| RequestError::Usage(format!("{flag}: {error}, found {text}")))
        };
        self.texts()?.into_iter().map(parsed).collect()
    }

    fn named_as<T: Named>(&self, text: &str) -> Result<T, RequestError> {
        value_of(text).map_or_else(
            || {
                let names: Vec<&str> = T::NAMES.iter().map(|(name, ..)| *name).collect();
                self.expected(names.join(", "), text)
            },
            Ok,
        )
    }

    fn named<T: Named>(&self) -> Result<T, RequestError> {
        self.named_as(&self.text()?)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Map, json};

    use super::*;

    #[test]
    fn every_option_that_an_answer_lists_can_be_set_by_its_name() {
        let defaults = serde_json::to_value(PlanRequest::default()).unwrap();
        let other: Map<String, Value> = json!({
            "goal": "a.fold", "fold": 0.5, "crease": ["4=-45", "5=30"], "via": ["b.fold"],
            "goal_tolerance": 2.0, "limit": ["7=-30..60"], "bound": 1e-3, "bend": 1.0, "keep": true,
            "contact": 1e-5, "symmetry": "off", "vertices": "all", "collision": "off", "interpolation": "half-angle",
            "max_speed": 10.0, "max_accel": 90.0, "pace": "sparse", "max_knots": 9, "frames": "angles", "solver": "gradient", "search": "random",
            "objective": "sum", "seed": 7, "timeout": 2.0, "tolerance": 1e-3, "straighten": "on",
            "colors": "red=V",
        })
        .as_object()
        .unwrap()
        .clone();
        let mut request = PlanRequest::default();
        for (name, value) in &other {
            assert_ne!(defaults[name], *value, "{name}");
            request.set(&name.replace('_', "-"), value).unwrap();
        }
        let set = serde_json::to_value(&request).unwrap();
        assert_eq!(set, Value::Object(other));
        for name in defaults.as_object().unwrap().keys() {
            request.set(name, &Value::Null).unwrap();
        }
        assert_eq!(serde_json::to_value(&request).unwrap(), set);
    }

    #[test]
    fn values_of_other_kinds_are_refused_by_name() {
        let refusals = [
            (
                "bound",
                json!("much"),
                "--bound: expected a number, found much",
            ),
            (
                "seed",
                json!(-1),
                "--seed: expected a whole number from 0, found -1",
            ),
            (
                "keep",
                json!("yes"),
                "--keep: expected true or false, found \"yes\"",
            ),
            (
                "symmetry",
                json!("on"),
                "--symmetry: expected auto, off, found on",
            ),
            (
                "collision",
                json!(false),
                "--collision: expected a number or text, found false",
            ),
            (
                "limit",
                json!("7"),
                "--limit: expected I=MIN..MAX, the number of an edge and two angles in degrees, found 7",
            ),
            ("boud", json!(1), "unexpected argument '--boud' found"),
        ];
        for (name, value, message) in refusals {
            let error = PlanRequest::default().set(name, &value).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }
}
