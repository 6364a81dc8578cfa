//! Files that are made of the library's tables of options, families and formats: signatures of the Python package, a JSON
//! Schema, and documents. They are checked in, so that others can read them; these tests compare them with the tables.
//!
//! `FOLDPATH_GENERATE=1` writes them anew:
//!
//! ```text
//! FOLDPATH_GENERATE=1 cargo nextest run --release -p foldpath-cli generated
//! ```

use core::fmt::Write as _;
use std::fs;
use std::path::Path;

use foldpath::export::{FORMATS, Place};
use foldpath::request::{
    CheckRequest, ExportRequest, FAMILIES, Kind, OptionInfo, PlanRequest, ReadingRequest, Request,
    UnfoldRequest, paragraphs,
};
use serde_json::{Map, Value, json};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Compares a file with what the tables make of it, or writes it.
fn compare(name: &str, made: impl FnOnce(&str) -> String) {
    let path = Path::new(ROOT).join(name);
    let found = fs::read_to_string(&path).unwrap_or_default();
    let made = made(&found);
    if std::env::var_os("FOLDPATH_GENERATE").is_some() {
        fs::write(path, made).unwrap();
    } else {
        assert!(
            found == made,
            "{name}: see FOLDPATH_GENERATE in {}",
            file!()
        );
    }
}

/// Replaces what stands in `text` between two anchors, each of which has to be there; the end is the first one behind the
/// beginning.
fn replaced(text: &str, [begin, end]: [&str; 2], by: &str) -> String {
    let start = text.find(begin).unwrap_or_else(|| panic!("no {begin:?}")) + begin.len();
    let stop = text[start..]
        .find(end)
        .unwrap_or_else(|| panic!("no {end:?}"))
        + start;
    format!("{}{by}{}", &text[..start], &text[stop..])
}

fn listed(infos: Vec<OptionInfo>) -> impl Iterator<Item = OptionInfo> {
    infos.into_iter().filter(|info| !info.is_earlier_name)
}

/// Returns the paragraphs of a text as sentences in one line, without the last full stop.
fn sentences(text: &str) -> String {
    let all: Vec<String> = paragraphs(text).collect();
    let joined = all.join(". ").replace(".. ", ". ");
    joined.trim_end_matches('.').to_string()
}

mod python {
    use super::*;

    fn literal(value: &Value) -> String {
        match value {
            Value::Bool(true) => "True".into(),
            Value::Bool(false) => "False".into(),
            Value::Array(_) | Value::Null => "None".into(),
            value => value.to_string(),
        }
    }

    fn names(names: &[(&str, &str)]) -> String {
        let names: Vec<String> = names
            .iter()
            .map(|(name, _)| format!("\"{name}\""))
            .collect();
        format!("Literal[{}]", names.join(", "))
    }

    /// Returns a parameter with its type and default.
    fn parameter(info: &OptionInfo, default: &str) -> String {
        let kind = match info.kind {
            Kind::Number => "float".into(),
            Kind::Count => "int".into(),
            Kind::Flag => "bool".into(),
            Kind::Names(all) => names(all),
            // Files of fold angles, which may be arrays here.
            Kind::File if info.is_repeated => "Iterable[File | ArrayLike] | File".into(),
            Kind::File => "File | ArrayLike".into(),
            Kind::EdgeAngle => "Mapping[int, float] | Iterable[str] | str".into(),
            Kind::EdgeRange => {
                "Mapping[int, tuple[float, float]] | Iterable[str] | str | NDArray[np.float64]"
                    .into()
            }
            Kind::NumberOrName => "float | str".into(),
            _ => String::from("str"),
        };
        let none = if default == "None" { " | None" } else { "" };
        let name = match info.alias {
            "" => info.name,
            alias => alias,
        };
        match default {
            "" => format!("{name}: {kind}"),
            default => format!("{name}: {kind}{none} = {default}"),
        }
    }

    fn of_default(info: &OptionInfo) -> String {
        let default = if info.is_required() {
            String::new()
        } else {
            literal(&(info.default)())
        };
        parameter(info, &default)
    }

    /// Returns lines of parameters.
    fn parameters(parameters: impl Iterator<Item = String>) -> String {
        parameters.fold(String::new(), |mut lines, parameter| {
            let _infallible = writeln!(lines, "    {parameter},");
            lines
        })
    }

    /// Returns a line for each option in a docstring, wrapped.
    fn described(infos: impl Iterator<Item = OptionInfo>, indent: &str) -> String {
        let mut lines = String::new();
        for info in infos {
            let name = if info.alias.is_empty() {
                info.name
            } else {
                info.alias
            };
            let mut line = format!("{indent}- ``{name}``:");
            for word in sentences(info.text).split(' ').map(in_python) {
                if line.len() + 1 + word.len() > 118 {
                    let _infallible = writeln!(lines, "{line}");
                    line = format!("{indent} ");
                }
                line += " ";
                line += &word;
            }
            let _infallible = writeln!(lines, "{line}");
        }
        lines
    }

    /// Returns a word of a text, in which an option such as `--max-speed` has its name in Python.
    fn in_python(word: &str) -> String {
        let of_command = || {
            let (before, rest) = word.split_once("--")?;
            let end = rest.find(|c: char| !c.is_ascii_lowercase() && c != '-');
            let (option, after) = rest.split_at(end.unwrap_or(rest.len()));
            let after = match before {
                "" if !after.starts_with('`') => after,
                "`" => after.strip_prefix('`')?,
                _ => return None,
            };
            Some(format!("``{}``{after}", option.replace('-', "_")))
        };
        of_command().unwrap_or_else(|| word.to_string())
    }

    #[test]
    fn plan_has_every_option() {
        let own = PlanRequest::infos().into_iter();
        let reading: Vec<&str> = ReadingRequest::infos()
            .iter()
            .map(|info| info.name)
            .collect();
        // A pattern that was read already takes no options of reading.
        let signature = own.map(|info| {
            if reading.contains(&info.name) || info.is_earlier_name {
                parameter(&info, "None")
            } else {
                of_default(&info)
            }
        });
        compare("python/python/foldpath/_plan.py", |found| {
            let anchors = [
                "    pattern: Union[Pattern, Source],\n    *,\n",
                "    jobs: int",
            ];
            let found = replaced(found, anchors, &parameters(signature));
            let options = described(listed(PlanRequest::infos()), "    ");
            replaced(&found, ["    The options:\n\n", "    \"\"\"\n"], &options)
        });
    }

    #[test]
    fn read_and_the_families_have_every_option() {
        compare("python/python/foldpath/_pattern.py", |found| {
            let signature = parameters(ReadingRequest::infos().iter().map(of_default));
            let found = replaced(
                found,
                ["    source: Source,\n    *,\n", ") -> Pattern:"],
                &signature,
            );
            let options = described(ReadingRequest::infos().into_iter(), "    ");
            let found = replaced(
                &found,
                ["    The options:\n\n", "    Raises"],
                &format!("{options}\n"),
            );
            let mut families = String::new();
            for family in FAMILIES {
                let parameters: Vec<String> = family.parameters.iter().map(of_default).collect();
                let _infallible = write!(
                    families,
                    "\n\ndef {}({}) -> Pattern:\n    \"\"\"{}.\n\n{}    \"\"\"\n    return _family(\"{}\", locals())\n",
                    family.name.replace('-', "_"),
                    parameters.join(", "),
                    sentences(family.text).replace("cols", "columns"),
                    described(family.parameters.iter().copied(), "    "),
                    family.name
                );
            }
            let begin = "# The families, made of the table in host/src/request/families.rs.\n";
            replaced(&(found + "\u{0}"), [begin, "\u{0}"], &families).replace('\u{0}', "")
        });
    }

    #[test]
    fn unfold_has_every_option() {
        compare("python/python/foldpath/_unfold.py", |found| {
            let signature = parameters(UnfoldRequest::infos().iter().map(of_default));
            let anchors = ["    shape: Source,\n    *,\n", ") -> Unfolding:"];
            let found = replaced(found, anchors, &signature);
            let options = described(UnfoldRequest::infos().into_iter(), "    ");
            replaced(&found, ["    The options:\n\n", "    \"\"\"\n"], &options)
        });
    }

    #[test]
    fn check_and_export_have_every_option() {
        compare("python/python/foldpath/_motion.py", |found| {
            let formats: Vec<(&str, &str)> =
                FORMATS.iter().map(|format| (format.name, "")).collect();
            let found = replaced(found, ["\nFormat = ", "\n"], &names(&formats));
            let unit = |info: &OptionInfo| info.name == "unit";
            let infos = || {
                let reading = ReadingRequest::infos().into_iter().filter(unit);
                ExportRequest::infos().into_iter().chain(reading)
            };
            let signature = parameters(infos().map(|info| parameter(&info, "None")));
            let signature = signature.replace("    ", "        ");
            let found = replaced(
                &found,
                ["        to: Format,\n        *,\n", "    ) -> None:"],
                &signature,
            );
            let mut told = String::new();
            for format in FORMATS {
                let place = match format.place {
                    Place::File => "",
                    Place::Folder => "; ``file`` is a folder",
                    Place::Sequence => "; ``file`` is a folder, or the beginning of the names",
                };
                let _infallible = writeln!(
                    told,
                    "        - ``{}``: {}{place}",
                    format.name, format.text
                );
            }
            let options = described(infos(), "        ");
            let told = format!("{told}\n        The options:\n\n{options}");
            let found = replaced(
                &found,
                ["        The formats:\n\n", "        \"\"\"\n"],
                &told,
            );
            let signature = parameters(CheckRequest::infos().iter().map(of_default));
            let anchors = [
                "    motion: Union[Motion, Source],\n    *,\n",
                "    jobs: int",
            ];
            let found = replaced(&found, anchors, &signature);
            let options = described(CheckRequest::infos().into_iter(), "    ");
            let anchors = ["between them.\n\n    The options:\n\n", "    \"\"\"\n"];
            replaced(&found, anchors, &options)
        });
    }
}

#[test]
fn the_schema_has_every_option() {
    /// Returns the schema of a single value.
    fn single(info: &OptionInfo) -> Map<String, Value> {
        let mut schema = Map::new();
        let kind = match info.kind {
            Kind::Names(names) => {
                let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
                schema.insert("enum".into(), json!(names));
                return schema;
            }
            Kind::Number => "number",
            Kind::Count => "integer",
            Kind::Flag => "boolean",
            _ => "string",
        };
        schema.insert("type".into(), kind.into());
        if info.kind == Kind::NumberOrName {
            schema.insert("type".into(), json!(["number", "string"]));
        }
        if kind == "integer" {
            schema.insert("minimum".into(), 0.into());
        }
        if let Some(range) = info.range {
            let least = if range.is_open {
                "exclusiveMinimum"
            } else {
                "minimum"
            };
            schema.insert(least.into(), range.least.into());
            if range.is_bounded() {
                schema.insert("maximum".into(), range.most.into());
            }
        }
        schema
    }
    /// Returns the schema of the value in an answer.
    fn in_answer(info: &OptionInfo) -> Value {
        let mut schema = single(info);
        if info.is_repeated {
            schema = Map::from_iter([
                ("type".into(), "array".into()),
                ("items".into(), Value::Object(schema)),
            ]);
        } else if info.is_optional {
            match schema.get_mut("type") {
                Some(Value::Array(kinds)) => kinds.push("null".into()),
                Some(kind) => *kind = json!([kind.take(), "null"]),
                None => drop(
                    schema
                        .get_mut("enum")
                        .map(|names| names.as_array_mut().unwrap().push(Value::Null)),
                ),
            }
        }
        schema.insert("description".into(), sentences(info.text).into());
        Value::Object(schema)
    }
    /// Returns the schema of the value in a request: numbers may be texts, as on the command line.
    fn in_request(info: &OptionInfo) -> Value {
        let kinds = match info.kind {
            Kind::Names(names) if !info.is_repeated => {
                let names = names.iter().map(|(name, _)| json!(name));
                let names: Vec<Value> = names.chain([Value::Null]).collect();
                return json!({"enum": names, "description": sentences(info.text)});
            }
            Kind::Number | Kind::Count | Kind::NumberOrName => json!(["number", "string", "null"]),
            Kind::Flag => json!(["boolean", "null"]),
            _ if info.is_repeated => json!(["array", "string", "null"]),
            _ => json!(["string", "null"]),
        };
        json!({"type": kinds, "description": sentences(info.text), "default": (info.default)()})
    }
    let object = |infos: Vec<OptionInfo>, schema: fn(&OptionInfo) -> Value| -> Value {
        let names = infos.iter().map(|info| info.name);
        let required: Vec<&str> = names.collect();
        let properties: Map<String, Value> = infos
            .iter()
            .map(|info| (info.name.into(), schema(info)))
            .collect();
        json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    };
    let mut families = Vec::new();
    for family in FAMILIES {
        let mut schema = object(family.parameters.to_vec(), in_answer);
        schema["properties"]["family"] = json!({"enum": [family.name]});
        let required = family
            .parameters
            .iter()
            .filter(|info| info.is_required() && info.alias.is_empty());
        let required: Vec<&str> = ["family"]
            .into_iter()
            .chain(required.map(|info| info.name))
            .collect();
        for info in family
            .parameters
            .iter()
            .filter(|info| !info.alias.is_empty())
        {
            schema["properties"][info.alias] = schema["properties"][info.name].clone();
            if info.is_required() {
                schema["oneOf"] = json!([{"required": [info.name]}, {"required": [info.alias]}]);
            }
        }
        schema["required"] = json!(required);
        schema["description"] = sentences(family.text).into();
        families.push(schema);
    }
    let mut request = object(PlanRequest::infos(), in_request);
    request.as_object_mut().unwrap().remove("required");
    // Names may have - between their words.
    request["additionalProperties"] = true.into();
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "options of foldpath",
        "description": "Made of the tables in host/src/request. Angles are in degrees, times in seconds.",
        "$defs": {
            "options": object(listed(PlanRequest::infos()).collect(), in_answer),
            "plan": request,
            "generate": {"oneOf": families},
        },
    });
    compare("docs/schema/options.json", |_| format!("{schema:#}\n"));
}

#[test]
fn the_documents_list_options_families_and_formats() {
    let mut page = String::from(
        "# Options, families and formats\n\nThis page is made of the tables of the library, as `--help` is; \
         [commands.md](commands.md) says what does not fit here.\n",
    );
    let shown = |value: Value| match value {
        Value::String(text) => format!("`{text}`"),
        Value::Number(number) => format!("`{number}`"),
        _ => String::new(),
    };
    let mut table = |title: &str, infos: Vec<OptionInfo>| {
        let _infallible = write!(
            page,
            "\n## {title}\n\n| option | default | range | meaning |\n|---|---|---|---|\n"
        );
        for info in listed(infos) {
            let value = match (info.kind, info.value_name) {
                (Kind::Flag, _) => String::new(),
                (Kind::Names(names), _) => {
                    let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
                    format!(" {}", names.join("\\|"))
                }
                (_, "") => format!(" {}", info.name.to_uppercase()),
                (_, name) => format!(" {name}"),
            };
            let range = info
                .range
                .map(|range| range.to_string())
                .unwrap_or_default();
            let meaning = sentences(info.text)
                .replace('|', "\\|")
                .replace(" [default: no limit]", "");
            let default = shown((info.default)());
            let _infallible = writeln!(
                page,
                "| `--{}{value}` | {default} | {range} | {meaning} |",
                info.flag()
            );
        }
    };
    let own = |infos: Vec<OptionInfo>| {
        let reading = ReadingRequest::infos();
        infos
            .into_iter()
            .filter(|info| !reading.iter().any(|other| other.name == info.name))
            .collect()
    };
    table("`plan`", own(PlanRequest::infos()));
    table(
        "Drawings that `info`, `plan` and `export --to svg` read",
        ReadingRequest::infos(),
    );
    table("`check`", CheckRequest::infos());
    table("`unfold`", UnfoldRequest::infos());
    for family in FAMILIES {
        table(
            &format!(
                "`generate {}`: {}",
                family.name,
                paragraphs(family.text).next().unwrap()
            ),
            family.parameters.to_vec(),
        );
    }
    table("`export`", ExportRequest::infos());
    page += "\n| `--to` | options | content |\n|---|---|---|\n";
    for format in FORMATS {
        let options: Vec<String> = format
            .options
            .iter()
            .map(|name| format!("`--{name}`"))
            .collect();
        let _infallible = writeln!(
            page,
            "| `{}` | {} | {} |",
            format.name,
            options.join(", "),
            format.text
        );
    }
    compare("docs/options.md", |_| page);
}

#[test]
fn the_browser_has_every_format_that_is_a_file() {
    let files = FORMATS.iter().filter(|format| format.place == Place::File);
    let files: Vec<String> = files.map(|format| format!("\"{}\"", format.name)).collect();
    compare("web/npm/index.d.ts", |found| {
        let anchors = ["export type Format = \"fold\" | ", " | \"pattern\";"];
        replaced(found, anchors, &files.join(" | "))
    });
}

/// Every option can be set by its name, changes the answer's list of options, and is refused by its name.
#[test]
fn every_option_is_set_by_its_name() {
    let defaults = serde_json::to_value(PlanRequest::default()).unwrap();
    let mut request = PlanRequest::default();
    for info in listed(PlanRequest::infos()) {
        let given = match info.kind {
            Kind::Number => json!(0.5),
            Kind::Count => json!("7"),
            Kind::Flag => json!(true),
            Kind::Names(names) => json!(names.last().unwrap().0),
            Kind::EdgeAngle => json!(["4=-45", "5=30"]),
            Kind::EdgeRange => json!("7=-30..60"),
            Kind::NumberOrName => json!(0.25),
            _ => json!(match info.name {
                "colors" | "layers" => "red=V",
                "order" => "4 / 2-3=90,1",
                _ => "a.fold",
            }),
        };
        request.set(&info.flag(), &given).unwrap();
        let now = serde_json::to_value(&request).unwrap();
        assert_ne!(now[info.name], defaults[info.name], "{}", info.name);
        request.set(info.name, &Value::Null).unwrap();
        assert_eq!(serde_json::to_value(&request).unwrap(), now);
        let wrong = match info.kind {
            Kind::Flag => json!("yes"),
            _ => json!({}),
        };
        let refused = PlanRequest::default().set(info.name, &wrong).unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.starts_with(&format!("{}: expected ", info.name)),
            "{refused}"
        );
    }
    let refused = PlanRequest::default().set("boud", &json!(1)).unwrap_err();
    assert_eq!(refused.to_string(), "unexpected option boud");
}

/// The earlier name of `--vertices all`, for one release.
#[test]
fn reuse_off_is_another_name_of_all_vertices() {
    use foldpath::planner::Vertices;
    let mut request = PlanRequest::default();
    request.set("reuse", &json!("off")).unwrap();
    assert_eq!(request.options().unwrap().vertices, Vertices::All);
    assert_eq!(serde_json::to_value(&request).unwrap().get("reuse"), None);
}
