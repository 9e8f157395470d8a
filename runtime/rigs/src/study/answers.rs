//! Table of answers: reader with line and column of every error, and writer.

use std::io::{Read, Write};
use std::path::Path;

use crate::study::background::{BACKGROUND_COLUMNS, Background, is_left_out};
use crate::study::{BACKGROUND, LAST_QUESTIONS, OVERALL, QUESTIONS, SHEETS, TESTS};
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
    /// Comment in the subject's own words; empty for none.
    pub comment: String,
}

/// All answers of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Background of the subjects who gave it.
    pub background: Vec<Background>,
    /// Answers for each sheet.
    pub ratings: Vec<Rating>,
    /// Answers at the end.
    pub overall: Vec<Overall>,
}

/// Columns before the questions.
const HEAD: [&str; 4] = ["subject", "order", "test", "sheet"];

/// Column of the comments, on the line of the end.
const COMMENT: &str = "comment";

/// Positions of the columns in a table. Those of order, background and comment may be missing.
struct Columns {
    head: [usize; 3],
    order: Option<usize>,
    questions: Vec<usize>,
    background: [Option<usize>; BACKGROUND_COLUMNS.len()],
    comment: Option<usize>,
}

/// All columns, in their order.
fn column_names() -> impl Iterator<Item = &'static str> {
    HEAD.into_iter().chain(keys()).chain(BACKGROUND_COLUMNS).chain([COMMENT])
}

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
        let heads: Vec<_> = heads.iter().map(|h| h.trim_start_matches('\u{feff}')).collect();
        let names: Vec<&str> = column_names().collect();
        for (i, head) in heads.iter().enumerate() {
            let field = format!("column {}", i + 1);
            known(&field, head, names.iter()).map_err(|e| e.at_line(1))?;
            let first = heads[..i].iter().position(|before| before == head);
            let again = first.map(|first| format!("\"{head}\" is column {} already", first + 1));
            again.map_or(Ok(()), |problem| Err(InputError::new(field, problem).at_line(1)))?;
        }
        let column = |name: &str| {
            let at = heads.iter().position(|head| *head == name);
            at.ok_or_else(|| InputError::new(name, "is a column that the table lacks").at_line(1))
        };
        let columns = Columns {
            head: [column(HEAD[0])?, column(HEAD[2])?, column(HEAD[3])?],
            order: column(HEAD[1]).ok(),
            questions: keys().map(column).collect::<Result<Vec<_>, _>>()?,
            background: BACKGROUND_COLUMNS.map(|name| column(name).ok()),
            comment: column(COMMENT).ok(),
        };
        let mut all = Self::default();
        for record in reader.records() {
            let record = record.map_err(failed)?;
            let line = record.position().map_or(0, |p| p.line() as usize);
            all.take(&record, &columns).map_err(|e| e.at_line(line))?;
        }
        Ok(all)
    }

    fn take(&mut self, record: &csv::StringRecord, columns: &Columns) -> Result<(), InputError> {
        let text = |at: Option<usize>| at.and_then(|i| record.get(i)).unwrap_or_default();
        let [subject, test, sheet] = columns.head.map(|i| text(Some(i)).to_owned());
        if subject.is_empty() {
            return Err(InputError::new("subject", "says who answered, and is empty"));
        }
        let background = columns.background.map(text);
        if test == BACKGROUND {
            if self.background.iter().any(|b| b.subject == subject) {
                return Err(InputError::new("subject", format!("{subject} has a line of background before")));
            }
            self.background.push(Background::parse(subject, background)?);
            return Ok(());
        }
        for (name, given) in BACKGROUND_COLUMNS.iter().zip(background) {
            only_on(name, given, BACKGROUND)?;
        }
        let values = columns.questions.iter().zip(keys()).map(|(i, key)| whole(key, text(Some(*i)), 9));
        let values = values.collect::<Result<Vec<_>, _>>()?;
        let (each, last) = values.split_at(QUESTIONS.len());
        if test == OVERALL {
            if self.overall.iter().any(|o| o.subject == subject) {
                return Err(InputError::new("subject", format!("{subject} has ended the session before")));
            }
            let answers = std::array::from_fn(|i| last[i]);
            self.overall.push(Overall { subject, answers, comment: text(columns.comment).to_owned() });
            return Ok(());
        }
        only_on(COMMENT, text(columns.comment), OVERALL)?;
        known("test", &test, TESTS.iter().chain(&[BACKGROUND, OVERALL]))?;
        known("sheet", &sheet, SHEETS.iter())?;
        if self.ratings.iter().any(|r| (&r.subject, &r.test, &r.sheet) == (&subject, &test, &sheet)) {
            return Err(InputError::new("subject", format!("{subject} has rated {sheet} in {test} before")));
        }
        let order = whole("order", text(columns.order), TESTS.len() * SHEETS.len())?;
        let answers = std::array::from_fn(|i| each[i]);
        self.ratings.push(Rating { subject, order, test, sheet, answers });
        Ok(())
    }

    /// All subjects, in the order of the table.
    pub fn subjects(&self) -> Vec<&str> {
        let mut all: Vec<&str> = Vec::new();
        let named = self.ratings.iter().map(|r| &r.subject).chain(self.overall.iter().map(|o| &o.subject));
        let named = named.chain(self.background.iter().map(|b| &b.subject));
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
        self.background.extend(other.background);
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
        let empty = |count: usize| vec![String::new(); count];
        let extra = BACKGROUND_COLUMNS.len() + 1;
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record(column_names()).map_err(failed)?;
        for subject in self.subjects() {
            for b in self.background.iter().filter(|b| b.subject == subject) {
                let head = [b.subject.clone(), String::new(), BACKGROUND.to_owned(), String::new()];
                let questions = empty(QUESTIONS.len() + LAST_QUESTIONS.len());
                let line = head.into_iter().chain(questions).chain(b.texts()).chain(empty(1));
                writer.write_record(line).map_err(failed)?;
            }
            for r in self.ratings.iter().filter(|r| r.subject == subject) {
                let order = r.order.map_or_else(String::new, |o| o.to_string());
                let head = [r.subject.clone(), order, r.test.clone(), r.sheet.clone()];
                let rest = empty(LAST_QUESTIONS.len() + extra);
                writer.write_record(head.into_iter().chain(text(&r.answers)).chain(rest)).map_err(failed)?;
            }
            for o in self.overall.iter().filter(|o| o.subject == subject) {
                let head = [o.subject.clone(), String::new(), OVERALL.to_owned(), String::new()];
                let last = text(&o.answers).into_iter().chain(empty(BACKGROUND_COLUMNS.len()));
                let line = head.into_iter().chain(empty(QUESTIONS.len())).chain(last).chain([o.comment.clone()]);
                writer.write_record(line).map_err(failed)?;
            }
        }
        writer.flush().map_err(|e| InputError::new("", e.to_string()))
    }
}

/// Parses a whole number from 1 to `most`, or none.
fn whole<T: TryFrom<usize>>(column: &str, text: &str, most: usize) -> Result<Option<T>, InputError> {
    let number = text.parse().ok().filter(|n| (1..=most).contains(n)).and_then(|n| n.try_into().ok());
    let problem = || format!("\"{text}\" is not a whole number from 1 to {most}, or N/A");
    let is_wrong = number.is_none() && !is_left_out(text);
    if is_wrong { Err(InputError::new(column, problem())) } else { Ok(number) }
}

/// Rejects a value outside the lines of the test that its column is for.
fn only_on(column: &str, text: &str, test: &str) -> Result<(), InputError> {
    let problem = || format!("\"{text}\" belongs to the line with the test `{test}`");
    if text.is_empty() { Ok(()) } else { Err(InputError::new(column, problem())) }
}

fn known<'a>(field: &str, name: &str, all: impl Iterator<Item = &'a &'a str>) -> Result<(), InputError> {
    let all: Vec<&str> = all.copied().collect();
    let problem = || format!("\"{name}\" is none of {}", all.join(", "));
    if all.contains(&name) { Ok(()) } else { Err(InputError::new(field, problem())) }
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
        let outside = |column: &str, found: &str, most: u8| {
            format!("{column}: \"{found}\" is not a whole number from 1 to {most}, or N/A")
        };
        assert_eq!(refused("9,9,9,9,9,9,9,9", "9,9,9,-1,9,9,9,9"), format!("line 3: {}", outside("A4", "-1", 9)));
        assert_eq!(refused("a,1", "a,0"), format!("line 3: {}", outside("order", "0", 15)));
        assert_eq!(refused("A2,A3", "A2,A2"), "line 1: column 7: \"A2\" is column 6 already");
        assert!(refused("C1,C2", "C1,C9").starts_with("line 1: column 14: \"C9\" is none of subject, order, test"));
        assert!(refused("cube,shell", "tube,shell").starts_with("line 2: test: \"tube\" is none of cube"));
        assert!(refused("cube,shell", "cube,silk").contains("sheet: \"silk\" is none of slamm"));
        assert!(refused("B3,C1", "comment,C1").contains("B3: is a column"));
        assert!(refused("1,cube,trimm", "1,cube,shell").contains("has rated shell in cube before"));
        assert!(refused("a,1", ",1").contains("subject"));
        assert!(refused("a,2", "a,b").contains("order"));
        assert!(refused("5,\n", "5\n").contains("line 4"), "a field is missing");
    }
}
