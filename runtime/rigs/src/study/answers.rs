//! Table of answers: reader with line and column of every error, and writer.

use std::io::{Read, Write};
use std::path::Path;

use crate::study::{LAST_QUESTIONS, OVERALL, QUESTIONS, SHEETS, TESTS};
use sheetwork::InputError;

/// Answers of one subject for one sheet of one test.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rating {
    /// Subject.
    pub subject: String,
    /// Position of the sheet in the session, from 1, if known.
    pub order: Option<u32>,
    /// Test.
    pub test: String,
    /// Sheet.
    pub sheet: String,
    /// 1 to 9, or none.
    pub answers: [Option<u8>; QUESTIONS.len()],
}

impl Rating {
    /// Sum of the given answers.
    pub fn total(&self) -> f64 {
        self.answers.iter().flatten().map(|a| f64::from(*a)).sum()
    }
}

/// Answers of one subject at the end of the session.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overall {
    /// Subject.
    pub subject: String,
    /// 1 to 9, or none.
    pub answers: [Option<u8>; LAST_QUESTIONS.len()],
}

/// All answers of a study.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    /// Answers for each sheet.
    pub ratings: Vec<Rating>,
    /// Answers at the end.
    pub overall: Vec<Overall>,
}

/// Columns before the questions.
const HEAD: [&str; 4] = ["subject", "order", "test", "sheet"];

fn keys() -> impl Iterator<Item = &'static str> {
    QUESTIONS.iter().chain(&LAST_QUESTIONS).map(|q| q.key)
}

impl Answers {
    /// Reads a table from a file.
    ///
    /// # Errors
    /// An unreadable file, a missing column, or an invalid value.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let open = std::fs::File::open(file).map_err(|e| InputError::io(file, &e))?;
        Self::parse(open).map_err(|e| e.in_file(file))
    }

    /// Reads a table from any reader.
    ///
    /// # Errors
    /// As [`Answers::read`].
    pub fn parse(from: impl Read) -> Result<Self, InputError> {
        let failed = |e: csv::Error| {
            let line = e.position().map_or(1, |p| p.line() as usize);
            InputError::new("", e.to_string()).at_line(line)
        };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(from);
        let heads = reader.headers().map_err(failed)?.clone();
        let column = |name: &str| {
            let at = heads.iter().position(|h| h.trim_start_matches('\u{feff}') == name);
            at.ok_or_else(|| InputError::new(name, "is a column that the table lacks").at_line(1))
        };
        let head = [column(HEAD[0])?, column(HEAD[2])?, column(HEAD[3])?];
        let order = column(HEAD[1]).ok();
        let questions = keys().map(column).collect::<Result<Vec<_>, _>>()?;
        let mut all = Self::default();
        for record in reader.records() {
            let record = record.map_err(failed)?;
            let line = record.position().map_or(0, |p| p.line() as usize);
            all.take(&record, head, order, &questions).map_err(|e| e.at_line(line))?;
        }
        Ok(all)
    }

    fn take(
        &mut self,
        record: &csv::StringRecord,
        head: [usize; 3],
        order: Option<usize>,
        questions: &[usize],
    ) -> Result<(), InputError> {
        let [subject, test, sheet] = head.map(|i| record.get(i).unwrap_or_default().to_owned());
        if subject.is_empty() {
            return Err(InputError::new("subject", "says who answered, and is empty"));
        }
        let values = questions.iter().zip(keys()).map(|(i, key)| answer(key, record.get(*i).unwrap_or_default()));
        let values = values.collect::<Result<Vec<_>, _>>()?;
        let (each, last) = values.split_at(QUESTIONS.len());
        if test == OVERALL {
            if self.overall.iter().any(|o| o.subject == subject) {
                return Err(InputError::new("subject", format!("{subject} has ended the session before")));
            }
            let answers = std::array::from_fn(|i| last[i]);
            self.overall.push(Overall { subject, answers });
            return Ok(());
        }
        known("test", &test, TESTS.iter().chain(&[OVERALL]))?;
        known("sheet", &sheet, SHEETS.iter())?;
        if self.ratings.iter().any(|r| (&r.subject, &r.test, &r.sheet) == (&subject, &test, &sheet)) {
            return Err(InputError::new("subject", format!("{subject} has rated {sheet} in {test} before")));
        }
        let order = match order.and_then(|i| record.get(i)).filter(|text| !text.is_empty()) {
            Some(text) => {
                let wrong = |_| InputError::new("order", format!("\"{text}\" is not a whole number"));
                Some(text.parse().map_err(wrong)?)
            }
            None => None,
        };
        let answers = std::array::from_fn(|i| each[i]);
        self.ratings.push(Rating { subject, order, test, sheet, answers });
        Ok(())
    }

    /// All subjects, in the order of the table.
    pub fn subjects(&self) -> Vec<&str> {
        let mut all: Vec<&str> = Vec::new();
        let named = self.ratings.iter().map(|r| &r.subject).chain(self.overall.iter().map(|o| &o.subject));
        for subject in named {
            if !all.contains(&subject.as_str()) {
                all.push(subject);
            }
        }
        all
    }

    /// Adds the answers of another table.
    ///
    /// # Errors
    /// A subject that is in both tables.
    pub fn merge(&mut self, other: Self) -> Result<(), InputError> {
        if let Some(twice) = other.subjects().into_iter().find(|s| self.subjects().contains(s)) {
            return Err(InputError::new("subject", format!("{twice} is in two of the tables")));
        }
        self.ratings.extend(other.ratings);
        self.overall.extend(other.overall);
        Ok(())
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Failure to write.
    pub fn write(&self, to: impl Write) -> Result<(), InputError> {
        let failed = |e: csv::Error| InputError::new("", e.to_string());
        let text = |answers: &[Option<u8>]| -> Vec<String> {
            answers.iter().map(|a| a.map_or_else(String::new, |a| a.to_string())).collect()
        };
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record(HEAD.into_iter().chain(keys())).map_err(failed)?;
        for subject in self.subjects() {
            for r in self.ratings.iter().filter(|r| r.subject == subject) {
                let order = r.order.map_or_else(String::new, |o| o.to_string());
                let head = [r.subject.clone(), order, r.test.clone(), r.sheet.clone()];
                let last = text(&[None; LAST_QUESTIONS.len()]);
                writer.write_record(head.into_iter().chain(text(&r.answers)).chain(last)).map_err(failed)?;
            }
            for o in self.overall.iter().filter(|o| o.subject == subject) {
                let head = [o.subject.clone(), String::new(), OVERALL.to_owned(), String::new()];
                let each = text(&[None; QUESTIONS.len()]);
                writer.write_record(head.into_iter().chain(each).chain(text(&o.answers))).map_err(failed)?;
            }
        }
        writer.flush().map_err(|e| InputError::new("", e.to_string()))
    }
}

/// Parses an answer: 1 to 9, or none.
fn answer(key: &str, text: &str) -> Result<Option<u8>, InputError> {
    if text.is_empty() || text.eq_ignore_ascii_case("n/a") {
        return Ok(None);
    }
    let number = text.parse().ok().filter(|n| (1..=9).contains(n));
    number.map(Some).ok_or_else(|| InputError::new(key, format!("\"{text}\" is no answer: 1 to 9, or N/A")))
}

fn known<'a>(field: &str, name: &str, all: impl Iterator<Item = &'a &'a str>) -> Result<(), InputError> {
    let all: Vec<&str> = all.copied().collect();
    if all.contains(&name) {
        return Ok(());
    }
    Err(InputError::new(field, format!("\"{name}\" is none of {}", all.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "subject,order,test,sheet,A1,A2,A3,A4,A5,B1,B2,B3,C1,C2\n\
        a,2,cube,shell,1,2,3,4,N/A,6,7,8,,\na,1,cube,trimm,9,9,9,9,9,9,9,9,,\na,,overall,,,,,,,,,,5,\n";

    #[test]
    fn a_table_survives_a_round_trip() {
        let read = Answers::parse(TABLE.as_bytes()).expect("valid");
        assert_eq!((read.ratings.len(), read.overall.len(), read.subjects()), (2, 1, vec!["a"]));
        assert_eq!(read.ratings[0].answers[4], None);
        assert_eq!((read.ratings[0].order, read.ratings[0].total()), (Some(2), 31.0));
        let mut text = Vec::new();
        read.write(&mut text).expect("room");
        assert_eq!(Answers::parse(text.as_slice()).expect("valid"), read);
    }

    #[test]
    fn an_invalid_table_is_rejected_with_line_and_column() {
        let refused = |from: &str, to: &str| {
            assert!(TABLE.contains(from));
            Answers::parse(TABLE.replacen(from, to, 1).as_bytes()).expect_err(to).to_string()
        };
        assert_eq!(refused("9,9,9,9,9,9,9,9", "9,9,9,10,9,9,9,9"), "line 3: A4: \"10\" is no answer: 1 to 9, or N/A");
        assert!(refused("cube,shell", "tube,shell").starts_with("line 2: test: \"tube\" is none of cube"));
        assert!(refused("cube,shell", "cube,silk").contains("sheet: \"silk\" is none of slamm"));
        assert!(refused("B3,C1", "B4,C1").contains("B3: is a column"));
        assert!(refused("1,cube,trimm", "1,cube,shell").contains("has rated shell in cube before"));
        assert!(refused("a,1", ",1").contains("subject"));
        assert!(refused("a,2", "a,b").contains("order"));
        assert!(refused("5,\n", "5\n").contains("line 4"), "a field is missing");
    }
}
