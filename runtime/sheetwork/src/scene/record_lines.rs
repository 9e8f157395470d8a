//! Lines of the letter-record text formats (.SHT, .POL, .heater), and exact conversion of units.
//!
//! One record a line: a letter, then fields, separated by blanks. Empty lines and lines that start
//! with `#` are skipped. Both line endings are read; a byte order mark before the first line is
//! skipped.
//!
//! The files use the units of the thesis and the program uses SI. They differ by powers of ten, so
//! units are converted in the decimal text, by its exponent: "1.3" cm is parsed as 1.3e-2, since
//! 1.3 / 100 may differ in the last bit. Written with the shortest digits that give the same
//! number, values survive any number of round trips unchanged.

use std::path::Path;

use crate::error::{InputError, check_range};

/// Numeric column: name, units and range.
pub(crate) struct RecordColumn {
    /// Record letter and name, for messages: "V.x".
    pub(crate) name: &'static str,
    /// Unit in the file.
    pub(crate) unit: &'static str,
    /// Unit in the program.
    pub(crate) si_unit: &'static str,
    /// Power of ten from the file's unit to SI.
    pub(crate) shift: i32,
    /// Least value, SI.
    pub(crate) min: f64,
    /// Largest value, SI.
    pub(crate) max: f64,
}

impl RecordColumn {
    /// Check a value in SI; `field` names it in the error.
    pub(crate) fn check(&self, field: impl FnOnce() -> String, value: f64) -> Result<(), InputError> {
        if value >= self.min && value <= self.max {
            return Ok(());
        }
        check_range(&field(), value, self.min, self.max, self.si_unit)
    }

    /// The name without its record letter.
    pub(crate) fn short(&self) -> &'static str {
        self.name.split_once('.').map_or(self.name, |(_, short)| short)
    }

    /// The range in the file's unit, in words.
    fn range(&self) -> String {
        let (min, max) = (decimal(self.min, self.shift), decimal(self.max, self.shift));
        format!("{min} to {max} {}", self.unit).trim_end().to_owned()
    }

    /// Parse the text of a field as a value in SI.
    fn parse(&self, token: &str) -> Result<f64, InputError> {
        let value = number(token, self.shift).ok_or_else(|| {
            InputError::new(self.name, format!("{} is not a number ({})", quoted(token), self.range()))
        })?;
        if value >= self.min && value <= self.max {
            return Ok(value);
        }
        let found = format!("{} {}", quoted(token), self.unit);
        Err(InputError::new(self.name, format!("{} is outside {}", found.trim_end(), self.range())))
    }
}

/// Line that is neither empty nor a comment.
pub(crate) struct RecordLine<'t> {
    /// Line in the text, from 1.
    pub(crate) line: usize,
    /// First word, the record letter.
    pub(crate) letter: &'t str,
    /// Words after the letter.
    pub(crate) fields: Vec<&'t str>,
}

impl RecordLine<'_> {
    /// Error about `field` at this line.
    pub(crate) fn error(&self, field: impl Into<String>, problem: impl Into<String>) -> InputError {
        InputError::new(field, problem).at_line(self.line)
    }

    /// Error of a letter that the format does not have; `known` lists its letters.
    pub(crate) fn unknown(&self, known: &str) -> InputError {
        self.error("", format!("unknown record {}: a line starts with {known} or #", quoted(self.letter)))
    }

    /// Check that the record has `count` fields; `names` lists them.
    pub(crate) fn expect_fields(&self, count: usize, names: &str) -> Result<(), InputError> {
        let found = self.fields.len();
        if found == count {
            return Ok(());
        }
        let wanted = match count {
            0 => "no fields".to_owned(),
            1 => format!("1 field ({names})"),
            _ => format!("{count} fields ({names})"),
        };
        Err(self.error(self.letter, format!("takes {wanted}, found {found}")))
    }

    /// The field at `index` as a number in SI.
    pub(crate) fn number(&self, index: usize, column: &RecordColumn) -> Result<f64, InputError> {
        column.parse(self.field(index)).map_err(|error| error.at_line(self.line))
    }

    /// The field at `index` as a whole number below `limit`; `name` is as "S.a", `what` describes
    /// the counted object.
    pub(crate) fn whole(&self, index: usize, name: &str, limit: u64, what: &str) -> Result<u32, InputError> {
        let token = self.field(index);
        match token.parse::<u32>() {
            Ok(value) if u64::from(value) < limit => Ok(value),
            _ if limit == 0 => Err(self.error(name, format!("{} is not {what}: there is none", quoted(token)))),
            _ => Err(self.error(name, format!("{} is not {what}, 0 to {}", quoted(token), limit - 1))),
        }
    }

    /// The field at `index`, empty if there is none.
    pub(crate) fn field(&self, index: usize) -> &str {
        self.fields.get(index).copied().unwrap_or("")
    }
}

/// Records of a text, in order.
pub(crate) fn records(text: &str) -> impl Iterator<Item = RecordLine<'_>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.lines().enumerate().filter_map(|(index, line)| {
        let mut words = line.split_ascii_whitespace();
        let letter = words.next().filter(|word| !word.starts_with('#'))?;
        Some(RecordLine { line: index + 1, letter, fields: words.collect() })
    })
}

/// Number of the last line, for errors about records that are missing at the end.
pub(crate) fn last_line(text: &str) -> usize {
    text.lines().count().max(1)
}

/// A word of the file for a message: in quotes, escaped, and truncated.
pub(crate) fn quoted(token: &str) -> String {
    let short: String = token.chars().take(40).collect();
    let dots = if short.len() < token.len() { "..." } else { "" };
    format!("{short:?}{dots}")
}

/// Decimal number in `token` times ten to the `shift`, rounded once; `None` if it is not a plain
/// decimal number.
pub(crate) fn number(token: &str, shift: i32) -> Option<f64> {
    let (mantissa, exponent) = match token.find(['e', 'E']) {
        Some(at) => (&token[..at], token[at + 1..].parse::<i32>().ok()?),
        None => (token, 0),
    };
    // Only digits, one sign and one point are accepted: the standard parser would also accept "inf"
    // and "nan".
    let digits = mantissa.strip_prefix(['+', '-']).unwrap_or(mantissa);
    if !digits.bytes().all(|b| b.is_ascii_digit() || b == b'.') {
        return None;
    }
    let value = format!("{mantissa}e{}", exponent.saturating_add(shift)).parse::<f64>().ok()?;
    value.is_finite().then_some(value)
}

/// Shortest decimal text of `value` divided by ten to the `shift`: [`number`] with that shift gives
/// `value` back.
pub(crate) fn decimal(value: f64, shift: i32) -> String {
    let text = format!("{value:e}");
    let parts = text.split_once('e').and_then(|(mantissa, exponent)| Some((mantissa, exponent.parse::<i32>().ok()?)));
    // NaN and infinity have no exponent; they are written unchanged and rejected when read.
    let Some((mantissa, exponent)) = parts else { return text };
    if mantissa.trim_start_matches('-') == "0" {
        return mantissa.to_owned();
    }
    let exponent = exponent.saturating_sub(shift);
    if !(-6..=15).contains(&exponent) {
        return format!("{mantissa}e{exponent}");
    }
    let (sign, digits) = mantissa.strip_prefix('-').map_or(("", mantissa), |rest| ("-", rest));
    let digits = digits.replace('.', "");
    if exponent < 0 {
        return format!("{sign}0.{}{digits}", "0".repeat((-exponent - 1) as usize));
    }
    let whole = exponent as usize + 1;
    match digits.len() > whole {
        true => format!("{sign}{}.{}", &digits[..whole], &digits[whole..]),
        false => format!("{sign}{digits}{}", "0".repeat(whole - digits.len())),
    }
}

/// Read a text file and parse it, naming the file in errors.
pub(crate) fn read_file<T>(path: &Path, parse: impl Fn(&str) -> Result<T, InputError>) -> Result<T, InputError> {
    let text = std::fs::read_to_string(path).map_err(|error| InputError::io(path, &error))?;
    parse(&text).map_err(|error| error.in_file(path))
}

#[cfg(test)]
pub(crate) mod damage {
    //! Damaged copies of valid files, identical at every run.

    /// Generator of pseudo-random numbers (xorshift).
    pub(crate) struct RandomBytes(pub(crate) u64);

    impl RandomBytes {
        pub(crate) fn below(&mut self, limit: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 % limit.max(1) as u64) as usize
        }
    }

    /// Call `read` with `rounds` damaged copies of `text`: bytes and lines changed, dropped,
    /// doubled or swapped.
    pub(crate) fn try_all(text: &str, rounds: usize, mut read: impl FnMut(&str)) {
        let mut dice = RandomBytes(0x5eed_0123_4567_89ab);
        let words =
            ["-1", "4294967296", "1e400", "nan", "F", "P", "V", "*", "\n", "#", "1e-5", "S", "M", "D", "HOT", "é"];
        for _ in 0..rounds {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..=dice.below(3) {
                let at = dice.below(bytes.len());
                match dice.below(5) {
                    0 if !bytes.is_empty() => bytes[at] = dice.below(256) as u8,
                    1 if !bytes.is_empty() => drop(bytes.remove(at)),
                    2 => bytes.truncate(at),
                    3 => {
                        let word = words[dice.below(words.len())];
                        bytes.splice(at..at, word.bytes());
                    }
                    _ => swap_lines(&mut bytes, &mut dice),
                }
            }
            read(&String::from_utf8_lossy(&bytes));
        }
    }

    fn swap_lines(bytes: &mut Vec<u8>, dice: &mut RandomBytes) {
        let mut lines: Vec<&[u8]> = bytes.split(|b| *b == b'\n').collect();
        let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
        match dice.below(3) {
            0 => lines.swap(a, b),
            1 => lines.insert(a, lines[b]),
            _ => drop(lines.remove(a)),
        }
        *bytes = lines.join(&b'\n');
    }
}

#[cfg(test)]
mod tests {
    use super::damage::RandomBytes;
    use super::*;

    #[test]
    fn lines_are_cut_into_records_whatever_their_ends() {
        let text = "\u{feff}# note\r\n\r\nV 1  2\t3\r\n  F\n*";
        let found: Vec<_> = records(text).map(|r| (r.line, r.letter.to_owned(), r.fields.join(" "))).collect();
        assert_eq!(
            found,
            [(3, "V".into(), "1 2 3".into()), (4, "F".into(), String::new()), (5, "*".into(), String::new())]
        );
        assert_eq!(last_line(text), 5);
        assert_eq!(last_line(""), 1);
    }

    #[test]
    fn change_of_unit_rounds_once() {
        assert_eq!(number("1.3", -2), Some(0.013));
        assert_eq!(number("-281", -2), Some(-2.81));
        assert_eq!(number("+.5e1", -2), Some(0.05));
        assert_eq!(number("7.", 0), Some(7.0));
        // Division gives another number.
        assert_ne!(0.07 / 100.0, 0.0007);
        assert_eq!(number("0.07", -2), Some(0.0007));
    }

    #[test]
    fn only_plain_numbers_are_accepted() {
        let refused = [
            "", "-", "+", ".", "nan", "inf", "-inf", "1,5", "1e", "e5", "1e5e5", "1e+-5", "0x10", "1.2.3", "--1", "1_0",
        ];
        for token in refused {
            assert_eq!(number(token, -2), None, "{token:?}");
        }
        assert_eq!(number("1e400", -2), None, "too large to be finite");
        assert_eq!(number("1e99999999999", -2), None);
        assert_eq!(number("1e2147483647", 5), None, "the exponent does not overflow");
    }

    #[test]
    fn every_number_survives_writing_and_reading_in_every_unit() {
        let mut dice = RandomBytes(42);
        let mut values = vec![0.0, -0.0, 1.0, -2.81e-2, 0.1, 1e22, 1e-7, f64::MAX / 1e6, f64::MIN_POSITIVE, 5e-324];
        for _ in 0..20_000 {
            dice.below(1);
            values.push(f64::from_bits(dice.0));
            values.push(dice.below(2_000_000) as f64 / 1e5 - 10.0);
        }
        for value in values.into_iter().filter(|v| v.abs() < 1e300) {
            for shift in [-4, -3, -2, 0] {
                let text = decimal(value, shift);
                let back = number(&text, shift).expect("written by us");
                assert_eq!(back.to_bits(), value.to_bits(), "{value:e} as {text}");
                assert_eq!(decimal(back, shift), text);
            }
        }
    }

    #[test]
    fn written_numbers_are_plain_where_that_is_short() {
        assert_eq!(decimal(-0.0281, -2), "-2.81");
        assert_eq!(decimal(0.025, -2), "2.5");
        assert_eq!(decimal(12.0, -2), "1200");
        assert_eq!(decimal(1.5e-6, -2), "0.00015");
        assert_eq!(decimal(1e-20, -2), "1e-18");
        assert_eq!(decimal(-0.0, -2), "-0");
        assert_eq!(decimal(f64::NAN, -2), "NaN");
    }

    #[test]
    fn messages_name_field_value_unit_and_range() {
        let column = RecordColumn { name: "V.x", unit: "cm", si_unit: "m", shift: -2, min: -1e4, max: 1e4 };
        let error = |token: &str| column.parse(token).expect_err("bad").to_string();
        assert_eq!(error("2e6"), "V.x: \"2e6\" cm is outside -1000000 to 1000000 cm");
        assert_eq!(error("a\u{7}"), "V.x: \"a\\u{7}\" is not a number (-1000000 to 1000000 cm)");
        assert_eq!(column.parse("1000000"), Ok(1e4));
        assert!(error(&"9".repeat(5000)).len() < 120, "a long word is cut");
        let record = RecordLine { line: 4, letter: "S", fields: vec!["7", "-1"] };
        assert_eq!(record.whole(0, "S.a", 8, "a mass").ok(), Some(7));
        let error = record.whole(1, "S.b", 8, "a mass").expect_err("negative");
        assert_eq!(error.to_string(), "line 4: S.b: \"-1\" is not a mass, 0 to 7");
        assert!(record.whole(0, "S.a", 0, "a mass").expect_err("none").problem.contains("there is none"));
        let error = record.expect_fields(3, "x y z").expect_err("two");
        assert_eq!(error.to_string(), "line 4: S: takes 3 fields (x y z), found 2");
    }
}
