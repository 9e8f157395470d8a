//! Parser of a RON value as typed on a command line, into a tree of JSON values.
//!
//! It keeps the names of enum variants, unlike a plain RON reader: `Ball(0.01)` becomes `{"Ball":
//! 0.01}`, `Point(0, 1)` becomes `{"Point": [0, 1]}` and `Left` becomes `"Left"`, the forms that
//! deserialise into a scene. JSON is read too.

use serde_json::{Map, Number, Value};

/// Maximum depth of nested brackets; more than any field of a scene has.
const MAX_DEPTH: usize = 32;

/// Value of `text`; `None` when it is not one whole value.
pub(crate) fn value_of(text: &str) -> Option<Value> {
    let mut reader = RonReader { text, depth: 0 };
    let value = reader.value()?;
    reader.text.trim_start().is_empty().then_some(value)
}

/// Reader from the front of `text`, which shrinks.
struct RonReader<'a> {
    text: &'a str,
    depth: usize,
}

impl<'a> RonReader<'a> {
    fn peek(&mut self) -> Option<char> {
        self.text = self.text.trim_start();
        self.text.chars().next()
    }

    fn eat(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.text = &self.text[wanted.len_utf8()..];
        }
        found
    }

    fn word(&mut self) -> &'a str {
        let end = self.text.find(|c: char| !c.is_ascii_alphanumeric() && !"_.+-".contains(c));
        let (word, rest) = self.text.split_at(end.unwrap_or(self.text.len()));
        self.text = rest;
        word
    }

    fn value(&mut self) -> Option<Value> {
        match self.peek()? {
            '"' => self.string().map(Value::String),
            '(' => self.group(')'),
            '[' => self.group(']'),
            '{' => self.group('}'),
            _ => {
                let word = self.word();
                if word.is_empty() {
                    return None;
                }
                if self.peek() == Some('(') { self.variant(word) } else { plain(word) }
            }
        }
    }

    /// `Name(...)`: one value inside is the content itself, several form a list.
    fn variant(&mut self, name: &str) -> Option<Value> {
        let inner = match self.group(')')? {
            Value::Array(mut items) if items.len() == 1 => items.remove(0),
            inner => inner,
        };
        if name == "Some" { Some(inner) } else { Some(Value::Object(Map::from_iter([(name.to_owned(), inner)]))) }
    }

    /// Bracketed group up to `close`: a map when its items have names, a list otherwise.
    fn group(&mut self, close: char) -> Option<Value> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return None;
        }
        self.text = &self.text[1..];
        let (mut items, mut fields) = (Vec::new(), Map::new());
        while !self.eat(close) {
            let value = self.value()?;
            match value {
                Value::String(name) if self.eat(':') => drop(fields.insert(name, self.value()?)),
                value => items.push(value),
            }
            if !self.eat(',') && self.peek() != Some(close) {
                return None;
            }
        }
        self.depth -= 1;
        match (items.is_empty(), fields.is_empty()) {
            (true, true) if close == '}' => Some(Value::Object(fields)),
            (true, false) => Some(Value::Object(fields)),
            (_, true) => Some(Value::Array(items)),
            (false, false) => None,
        }
    }

    fn string(&mut self) -> Option<String> {
        let mut found = serde_json::Deserializer::from_str(self.text).into_iter::<String>();
        let string = found.next()?.ok()?;
        let read = found.byte_offset();
        self.text = self.text.get(read..)?;
        Some(string)
    }
}

/// Number, boolean, none, or word.
fn plain(word: &str) -> Option<Value> {
    match word {
        "true" => return Some(Value::Bool(true)),
        "false" => return Some(Value::Bool(false)),
        "none" | "None" | "null" => return Some(Value::Null),
        _ => {}
    }
    if let Ok(whole) = word.parse::<i64>() {
        return Some(whole.into());
    }
    if word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        return Number::from_f64(word.parse().ok()?).map(Value::Number);
    }
    Some(Value::String(word.to_owned()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::value_of;

    #[test]
    fn values_keep_the_names_of_their_variants() {
        let read = |text: &str| value_of(text).expect("a value");
        assert_eq!(read("2e9"), json!(2e9));
        assert_eq!(read(" -.5 "), json!(-0.5));
        assert_eq!(read("(5, 3, 4)"), json!([5, 3, 4]));
        assert_eq!(read("Ball(0.01)"), json!({ "Ball": 0.01 }));
        assert_eq!(read("Box((1, 2, 3.5,))"), json!({ "Box": [1, 2, 3.5] }));
        assert_eq!(read("File(\"a \\\" b.pol\")"), json!({ "File": "a \" b.pol" }));
        assert_eq!(read("Some(0.2)"), json!(0.2));
        assert_eq!(
            read("[(region: Rect((0, 0.1), (0, 1)), path: []), (region: Left)]"),
            json!([{ "region": { "Rect": [[0, 0.1], [0, 1]] }, "path": [] }, { "region": "Left" }])
        );
        assert_eq!(read("{\"tip\": (1.0, 0.5)}"), json!({ "tip": [1.0, 0.5] }));
        assert_eq!(read("{}"), json!({}));
        assert_eq!(read("()"), json!([]));
    }

    #[test]
    fn incomplete_values_are_rejected() {
        let deep = "(".repeat(100_000);
        for text in ["", "(", "(1 2)", "1 2", "(a: 1, 2)", "[1", "Ball(", "\"open", "1e400", "1.2.3", "é", "(:", &deep]
        {
            assert_eq!(value_of(text), None, "{text:.40}");
        }
    }
}
