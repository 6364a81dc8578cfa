//! Stores a JSON text as one flat list of values in pre-order, sixteen bytes each, so that a file of numbers takes
//! little more memory than its text.

use core::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// A value. The entries of a list or an object directly follow it.
#[derive(Clone, Copy)]
enum Node {
    Null,
    Bool(bool),
    Unsigned(u64),
    Negative(i64),
    Float(f64),
    /// A range of bytes in `Json::texts`.
    Text {
        len: u32,
        start: usize,
    },
    /// `end` is the index behind the last entry.
    List {
        len: u32,
        end: usize,
    },
    /// Keys, each directly before its value; `end` is the index behind the last value.
    Object {
        end: usize,
    },
}

/// A parsed JSON text.
#[derive(Default)]
pub(super) struct Json {
    nodes: Vec<Node>,
    texts: String,
}

impl Json {
    pub(super) fn parse(text: &[u8]) -> serde_json::Result<Self> {
        let mut json = Self::default();
        let mut parser = serde_json::Deserializer::from_slice(text);
        Builder(&mut json).deserialize(&mut parser)?;
        parser.end()?;
        json.nodes.shrink_to_fit();
        Ok(json)
    }

    pub(super) fn root(&self) -> Value<'_> {
        Value { json: self, at: 0 }
    }
}

/// Deserialises a value and appends it to the list.
struct Builder<'a>(&'a mut Json);

impl Builder<'_> {
    fn add<E>(self, node: Node) -> Result<(), E> {
        self.0.nodes.push(node);
        Ok(())
    }
}

fn length<E: Error>(len: usize) -> Result<u32, E> {
    u32::try_from(len).map_err(|_| E::custom("more than 2^32 entries or characters in one value"))
}

impl<'de> DeserializeSeed<'de> for Builder<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, parser: D) -> Result<(), D::Error> {
        parser.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Builder<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any valid JSON value")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.add(Node::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.add(Node::Bool(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.add(Node::Unsigned(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.add(Node::Negative(value))
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.add(Node::Float(value))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<(), E> {
        let (len, start) = (length(value.len())?, self.0.texts.len());
        self.0.texts.push_str(value);
        self.add(Node::Text { len, start })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        let list = self.0.nodes.len();
        self.0.nodes.push(Node::Null);
        let mut len = 0;
        while entries.next_element_seed(Builder(self.0))?.is_some() {
            len += 1;
        }
        let (len, end) = (length(len)?, self.0.nodes.len());
        self.0.nodes[list] = Node::List { len, end };
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        let object = self.0.nodes.len();
        self.0.nodes.push(Node::Null);
        while entries.next_key_seed(Builder(self.0))?.is_some() {
            entries.next_value_seed(Builder(self.0))?;
        }
        let end = self.0.nodes.len();
        self.0.nodes[object] = Node::Object { end };
        Ok(())
    }
}

/// A value of a parsed JSON text, by its index.
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    json: &'a Json,
    at: usize,
}

impl<'a> Value<'a> {
    fn node(&self) -> Node {
        self.json.nodes[self.at]
    }

    /// Returns the value that follows this value and all its entries.
    fn next(self) -> Self {
        let at = match self.node() {
            Node::List { end, .. } | Node::Object { end } => end,
            _ => self.at + 1,
        };
        Self { at, ..self }
    }

    fn first_inside(self) -> Self {
        Self {
            at: self.at + 1,
            ..self
        }
    }

    pub(super) fn is_null(&self) -> bool {
        matches!(self.node(), Node::Null)
    }

    pub(super) fn is_true(&self) -> bool {
        self.as_bool() == Some(true)
    }

    pub(super) fn as_bool(&self) -> Option<bool> {
        match self.node() {
            Node::Bool(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn is_object(&self) -> bool {
        matches!(self.node(), Node::Object { .. })
    }

    #[allow(clippy::cast_precision_loss, reason = "the nearest number")]
    pub(super) fn as_f64(&self) -> Option<f64> {
        match self.node() {
            Node::Unsigned(value) => Some(value as f64),
            Node::Negative(value) => Some(value as f64),
            Node::Float(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn as_u64(&self) -> Option<u64> {
        match self.node() {
            Node::Unsigned(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn as_str(&self) -> Option<&'a str> {
        match self.node() {
            Node::Text { len, start } => self.json.texts.get(start..start + len as usize),
            _ => None,
        }
    }

    /// Returns the entries of a list, or `None` for any other value.
    pub(super) fn list(&self) -> Option<impl ExactSizeIterator<Item = Value<'a>> + use<'a>> {
        let Node::List { len, .. } = self.node() else {
            return None;
        };
        let mut next = self.first_inside();
        Some((0..len as usize).map(move |_| {
            let entry = next;
            next = entry.next();
            entry
        }))
    }

    /// Returns the value of a key. If the key occurs more than once, the last value counts.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        let found = self
            .members()
            .filter(|(name, _)| name.as_str() == Some(key));
        found.last().map(|(_, value)| value)
    }

    /// Returns the keys of an object with their values; any other value has none.
    pub(super) fn members(&self) -> impl Iterator<Item = (Value<'a>, Value<'a>)> + use<'a> {
        let mut next = self.first_inside();
        let end = match self.node() {
            Node::Object { end } => end,
            _ => next.at,
        };
        core::iter::from_fn(move || {
            let key = (next.at < end).then_some(next)?;
            let value = key.next();
            next = value.next();
            Some((key, value))
        })
    }

    /// Describes the value in words short enough for a message.
    pub(super) fn kind(&self) -> String {
        let plain = |value: serde_json::Value| value.to_string();
        match self.node() {
            Node::Null => "null".into(),
            Node::Bool(value) => value.to_string(),
            Node::Unsigned(value) => value.to_string(),
            Node::Negative(value) => value.to_string(),
            Node::Float(value) => plain(value.into()),
            Node::List { len, .. } => format!("a list of {len}"),
            Node::Object { .. } => "an object".into(),
            Node::Text { .. } => {
                let text = self.as_str().unwrap_or_default();
                if text.chars().count() > 20 {
                    format!("\"{}...\"", text.chars().take(20).collect::<String>())
                } else {
                    plain(text.into())
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Converts the value to serde_json's type.
    fn plain(value: Value<'_>) -> serde_json::Value {
        use serde_json::Value as Plain;
        if let Some(list) = value.list() {
            return Plain::Array(list.map(plain).collect());
        }
        match value.node() {
            Node::Null => Plain::Null,
            Node::Bool(value) => value.into(),
            Node::Unsigned(value) => value.into(),
            Node::Negative(value) => value.into(),
            Node::Float(value) => value.into(),
            _ => value.as_str().into(),
        }
    }

    #[test]
    fn values_are_those_of_another_parser() {
        let text = r#"[[], null, [1, [-2, 3.5e-7, 18446744073709551615], "a\u00e9\"b"], true, -0, 0.1, ""]"#;
        let json = Json::parse(text.as_bytes()).unwrap();
        let expected: serde_json::Value = serde_json::from_str(text).unwrap();
        assert_eq!(plain(json.root()), expected);
        assert_eq!(size_of::<Node>(), 16);
    }

    #[test]
    fn keys_are_found_behind_nested_values_and_the_last_one_counts() {
        let text = r#"{"a": {"b": [1, {"b": 2}], "": 0}, "b": 3, "c": [4], "b": -5}"#;
        let json = Json::parse(text.as_bytes()).unwrap();
        let root = json.root();
        assert_eq!(root.get("b").and_then(|b| b.as_f64()), Some(-5.0));
        assert_eq!(
            root.get("c").and_then(|c| c.list()).map(|c| c.len()),
            Some(1)
        );
        let inner = root.get("a").and_then(|a| a.get("b"));
        let mut inner = inner.and_then(|b| b.list()).unwrap();
        assert_eq!(inner.next().and_then(|one| one.as_u64()), Some(1));
        let two = inner.next().and_then(|object| object.get("b"));
        assert_eq!(two.and_then(|two| two.as_u64()), Some(2));
        assert!(root.get("d").is_none() && root.get("c").unwrap().get("c").is_none());
    }
}
