//! Position of the value of a dotted path in a RON text, for error messages about values that
//! parsed but are invalid.
//!
//! The walker follows brackets, strings, comments and `name:` in a text that the RON parser has
//! already accepted.

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

/// Byte of the value at `path`, or of the deepest existing part of the path.
fn deepest(text: &str, path: &str) -> usize {
    let mut walker = Walker { bytes: text.as_bytes(), at: 0, deepest: 0 };
    let path: Vec<&str> = path.split('.').filter(|s| !s.is_empty()).collect();
    walker.value(Some(&path));
    walker.deepest
}

struct Walker<'a> {
    bytes: &'a [u8],
    at: usize,
    deepest: usize,
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
            Some(b'(' | b'[' | b'{') => self.group(path),
            Some(_) => {
                let start = self.at;
                self.word();
                self.skip_blank();
                if self.peek() == Some(b'(') {
                    self.group(path);
                } else if self.at == start {
                    // Unknown character: skip it to guarantee progress.
                    self.at += 1;
                }
            }
            None => {}
        }
    }

    fn group(&mut self, path: Option<&[&str]>) {
        self.at += 1;
        let mut index = 0_usize;
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
                    self.value(inner.map(|(_, rest)| rest));
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
    use super::{line_of, value_of};

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
    fn does_not_hang_or_panic_on_broken_text() {
        for end in 0..TEXT.len() {
            line_of(&TEXT[..end], "sheets.1.material.young");
            value_of(&TEXT[..end], "sheets.1.material.young");
        }
        line_of("((((\"\\", "0.0.0.0");
        line_of("}{)(%%%", "a.b");
    }
}
