//! Position of the value of a dotted path in a RON text, for error messages about values that
//! parsed but are invalid.
//!
//! The walker follows brackets, strings, comments and `name:` in a text that the RON parser has
//! already accepted, and numbers that it has not.

use crate::scene::nesting;

/// Line (from 1) of the value at `path` (`sheets.0.material.young`), or of the deepest existing
/// part of the path.
pub(crate) fn line_of(text: &str, path: &str) -> usize {
    1 + text.as_bytes()[..deepest(text, path).min(text.len())].iter().filter(|b| **b == b'\n').count()
}

/// The value at `path` as written, truncated for a message; `None` when it does not exist or is a
/// group.
///
/// The text may be invalid after the place where the parser stopped.
pub(crate) fn value_of(text: &str, path: &str) -> Option<String> {
    let (outer, name) = path.rsplit_once('.').unwrap_or(("", path));
    let (group, start) = (deepest(text, outer), deepest(text, path));
    if name.is_empty() || start <= group {
        return None;
    }
    let rest = text.get(start..)?.lines().next()?;
    let end = match rest.strip_prefix('"') {
        Some(string) => string.find('"').map(|i| i + 2),
        None => rest.find([',', ')', ']', '}']),
    };
    let value: String = rest[..end.unwrap_or(rest.len())].chars().take(40).collect();
    (!value.is_empty() && !value.starts_with(['(', '[', '{'])).then(|| value.trim_end().to_owned())
}

/// Path and text of the first number of `text` that is not plain: with a unit, or not finite.
pub(crate) fn first_bad_number(text: &str) -> Option<(String, String)> {
    nesting::check(text).ok()?;
    let mut walker = Walker { bytes: text.as_bytes(), ..Walker::default() };
    walker.value(None);
    walker.bad_number
}

/// Byte of the value at `path`, or of the deepest existing part of the path.
fn deepest(text: &str, path: &str) -> usize {
    let mut walker = Walker { bytes: text.as_bytes(), ..Walker::default() };
    let path: Vec<&str> = path.split('.').filter(|s| !s.is_empty()).collect();
    walker.value(Some(&path));
    walker.deepest
}

/// Whether `text` is meant as a number, but has a unit or is not finite.
fn is_bad_number(text: &str) -> bool {
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    text.parse::<f64>().map_or_else(|_| begins && ron::from_str::<ron::Value>(text).is_err(), |v| !v.is_finite())
}

#[derive(Default)]
struct Walker<'a> {
    bytes: &'a [u8],
    at: usize,
    deepest: usize,
    /// Names and indices of the groups around the present value.
    names: Vec<String>,
    bad_number: Option<(String, String)>,
}

impl Walker<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn starts(&self, what: &[u8]) -> bool {
        self.bytes[self.at.min(self.bytes.len())..].starts_with(what)
    }

    fn skip_blank(&mut self) {
        while let Some(b) = self.peek() {
            if self.starts(b"//") || self.starts(b"#!") {
                while self.peek().is_some_and(|b| b != b'\n') {
                    self.at += 1;
                }
            } else if self.starts(b"/*") {
                while self.at < self.bytes.len() && !self.starts(b"*/") {
                    self.at += 1;
                }
                self.at += 2;
            } else if b.is_ascii_whitespace() {
                self.at += 1;
            } else {
                return;
            }
        }
    }

    fn word(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|b| b.is_ascii_alphanumeric() || b"_.+-".contains(&b)) {
            self.at += 1;
        }
        String::from_utf8_lossy(&self.bytes[start..self.at]).into_owned()
    }

    fn string(&mut self) -> String {
        self.at += 1;
        let start = self.at;
        while self.peek().is_some_and(|b| b != b'"') {
            self.at += if self.peek() == Some(b'\\') { 2 } else { 1 };
        }
        let end = self.at.min(self.bytes.len());
        self.at = end + 1;
        String::from_utf8_lossy(&self.bytes[start..end]).into_owned()
    }

    /// Walk one value; `path` is the remaining path inside it, `None` outside the path.
    fn value(&mut self, path: Option<&[&str]>) {
        self.skip_blank();
        if path.is_some() {
            self.deepest = self.at;
        }
        match self.peek() {
            Some(b'"') => drop(self.string()),
            Some(b'(' | b'[' | b'{') => {
                self.at += 1;
                self.items(path, 0);
            }
            Some(_) => {
                let start = self.at;
                self.word();
                self.skip_blank();
                if self.peek() == Some(b'(') {
                    // A group that comes first in an enum variant has the path of the variant.
                    self.at += 1;
                    self.skip_blank();
                    let is_group = matches!(self.peek(), Some(b'(' | b'['));
                    if is_group {
                        self.value(path.filter(|rest| !rest.is_empty()));
                    }
                    return self.items(path, usize::from(is_group));
                }
                // A scalar ends with its line, at a comment or at a delimiter.
                self.at = start;
                let ends = |w: &Self| w.starts(b"//") || w.starts(b"/*");
                while !ends(self) && self.peek().is_some_and(|b| !b",)]}\n".contains(&b)) {
                    self.at += 1;
                }
                let scalar = String::from_utf8_lossy(&self.bytes[start..self.at]).trim_end().to_owned();
                if self.bad_number.is_none() && is_bad_number(&scalar) {
                    self.bad_number = Some((self.names.join("."), scalar));
                }
            }
            None => {}
        }
    }

    /// Walk the items of a group from number `index`, and its closing bracket.
    fn items(&mut self, path: Option<&[&str]>, mut index: usize) {
        loop {
            self.skip_blank();
            match self.peek() {
                None => return,
                Some(b')' | b']' | b'}') => {
                    self.at += 1;
                    return;
                }
                Some(b',') => self.at += 1,
                Some(_) => {
                    let key = self.key().unwrap_or_else(|| index.to_string());
                    let inner = path.and_then(|p| p.split_first()).filter(|(first, _)| **first == key);
                    self.names.push(key);
                    self.value(inner.map(|(_, rest)| rest));
                    self.names.pop();
                    index += 1;
                }
            }
        }
    }

    /// Name before a colon, if `name:` comes next; otherwise nothing is consumed.
    fn key(&mut self) -> Option<String> {
        let start = self.at;
        let key = if self.peek() == Some(b'"') { self.string() } else { self.word() };
        self.skip_blank();
        if self.peek() == Some(b':') {
            self.at += 1;
            return Some(key);
        }
        self.at = start;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{first_bad_number, line_of, value_of};

    const TEXT: &str = r#"#![enable(implicit_some)]
// a comment: with a colon
(
    gravity: (0, -9.81, 0), /* (nested: brackets) */
    sheets: [
        (name: "a, (b)"),
        (
            name: "c",
            material: (
                young: 2e9,
                poisson: 0.3,
            ),
            probes: { "tip": (1.0, 0.5) },
        ),
    ],
)"#;

    #[test]
    fn finds_values_by_name_and_index() {
        assert_eq!(line_of(TEXT, "gravity.1"), 4);
        assert_eq!(line_of(TEXT, "sheets.1.name"), 8);
        assert_eq!(line_of(TEXT, "sheets.1.material.poisson"), 11);
        assert_eq!(line_of(TEXT, "sheets.1.probes.tip"), 13);
    }

    #[test]
    fn falls_back_to_the_deepest_part_that_is_there() {
        assert_eq!(line_of(TEXT, "sheets.1.material.density"), 9);
        assert_eq!(line_of(TEXT, "nothing"), 3);
    }

    #[test]
    fn finds_what_is_written() {
        assert_eq!(value_of(TEXT, "sheets.1.material.young").as_deref(), Some("2e9"));
        assert_eq!(value_of(TEXT, "sheets.0.name").as_deref(), Some("\"a, (b)\""));
        assert_eq!(value_of(TEXT, "gravity.1").as_deref(), Some("-9.81"));
        assert_eq!(value_of(TEXT, "gravity"), None);
        assert_eq!(value_of(TEXT, "sheets.1.material.density"), None);
        assert_eq!(value_of("(dt: \"é", "dt").as_deref(), Some("\"é"));
    }

    #[test]
    fn finds_numbers_that_are_not_plain() {
        let found = |text: &str| first_bad_number(text).map(|(path, number)| format!("{path}={number}"));
        assert_eq!(found("(a: 1, b: [(2, 3), (4, 0.1 kg)])").as_deref(), Some("b.1.1=0.1 kg"));
        assert_eq!(found("(o: Polygon([(0, 0), (nan, 1)]))").as_deref(), Some("o.1.0=nan"));
        assert_eq!(
            found("(s: Polyhedron((vertices: [(0, 1 mm // there\n, 2)])))").as_deref(),
            Some("s.vertices.0.1=1 mm")
        );
        assert_eq!(
            found("[1_000, 0x1F, -2.5e-3, \"3 m\", Rect((0, 1), (0, 1)), 4 /* m */, -inf]").as_deref(),
            Some("6=-inf")
        );
        assert_eq!((found(TEXT), found(&"(".repeat(100_000))), (None, None));
        assert_eq!(line_of("(o: Polygon([\n(0, 0),\n(1, 1)]))", "o.1.0"), 3);
    }

    #[test]
    fn does_not_hang_or_panic_on_broken_text() {
        for end in 0..TEXT.len() {
            line_of(&TEXT[..end], "sheets.1.material.young");
            value_of(&TEXT[..end], "sheets.1.material.young");
        }
        line_of("((((\"\\", "0.0.0.0");
        line_of("}{)(%%%", "a.b");
    }
}
