//! Background of the subjects: questionnaire of the thesis (6.3.3 and appendix D), and the
//! statistics of a population.

use serde::Serialize;

use crate::study::statistics::{Summary, summary};
use sheetwork::InputError;

/// Hours a week at a computer, in the classes of the questionnaire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "&'static str")]
pub enum WeeklyHours {
    /// Less than 1.
    Below1,
    /// 1 to 4.
    From1,
    /// 4 to 10.
    From4,
    /// 10 to 20.
    From10,
    /// Over 20.
    Over20,
}

impl WeeklyHours {
    /// All classes, from the least.
    pub const ALL: [Self; 5] = [Self::Below1, Self::From1, Self::From4, Self::From10, Self::Over20];

    /// Name in the table and on the screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Below1 => "<1",
            Self::From1 => "1-4",
            Self::From4 => "4-10",
            Self::From10 => "10-20",
            Self::Over20 => ">20",
        }
    }
}

impl From<WeeklyHours> for &'static str {
    fn from(hours: WeeklyHours) -> Self {
        hours.name()
    }
}

/// Sex, as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sex {
    /// Male.
    Male,
    /// Female.
    Female,
}

impl Sex {
    /// Both answers.
    pub const ALL: [Self; 2] = [Self::Male, Self::Female];

    /// Name in the table and on the screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Male => "male",
            Self::Female => "female",
        }
    }
}

/// Answers of one subject about their background; every one may be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Background {
    /// Subject.
    pub subject: String,
    /// Age, years; 1 to 120.
    pub age: Option<f64>,
    /// Sex.
    pub sex: Option<Sex>,
    /// Experience with computers, years; 0 to 100.
    pub years: Option<f64>,
    /// Hours a week at a computer.
    pub hours: Option<WeeklyHours>,
    /// Whether familiar with computer simulation, games excluded.
    pub simulation: Option<bool>,
    /// Whether familiar with advanced engineering or physics.
    pub physics: Option<bool>,
}

/// Columns of the questionnaire.
pub(crate) const BACKGROUND_COLUMNS: [&str; 6] = ["age", "sex", "years", "hours", "simulation", "physics"];

impl Background {
    /// Whether nothing was answered.
    pub fn is_empty(&self) -> bool {
        *self == Self { subject: self.subject.clone(), ..Self::default() }
    }

    /// Reads the texts of [`BACKGROUND_COLUMNS`].
    pub(crate) fn parse(subject: String, texts: [&str; 6]) -> Result<Self, InputError> {
        let [age, sex, years, hours, simulation, physics] = texts;
        Ok(Self {
            subject,
            age: number("age", age, (1.0, 120.0))?,
            sex: one_of("sex", sex, &Sex::ALL, Sex::name)?,
            years: number("years", years, (0.0, 100.0))?,
            hours: one_of("hours", hours, &WeeklyHours::ALL, WeeklyHours::name)?,
            simulation: one_of("simulation", simulation, &[true, false], yes_or_no)?,
            physics: one_of("physics", physics, &[true, false], yes_or_no)?,
        })
    }

    /// Texts of [`BACKGROUND_COLUMNS`].
    pub(crate) fn texts(&self) -> [String; 6] {
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        let name = |value: Option<&'static str>| value.unwrap_or_default().to_owned();
        [
            number(self.age),
            name(self.sex.map(Sex::name)),
            number(self.years),
            name(self.hours.map(WeeklyHours::name)),
            name(self.simulation.map(yes_or_no)),
            name(self.physics.map(yes_or_no)),
        ]
    }
}

fn yes_or_no(yes: bool) -> &'static str {
    if yes { "yes" } else { "no" }
}

/// Whether a question was left out.
pub(crate) fn is_left_out(text: &str) -> bool {
    text.is_empty() || text.eq_ignore_ascii_case("n/a")
}

fn number(field: &str, text: &str, (least, most): (f64, f64)) -> Result<Option<f64>, InputError> {
    if is_left_out(text) {
        return Ok(None);
    }
    let value = text.parse().ok().filter(|v| (least..=most).contains(v));
    let wrong = || InputError::new(field, format!("\"{text}\" is no number of years from {least} to {most}"));
    value.map(Some).ok_or_else(wrong)
}

fn one_of<T: Copy>(field: &str, text: &str, all: &[T], name: fn(T) -> &'static str) -> Result<Option<T>, InputError> {
    if is_left_out(text) {
        return Ok(None);
    }
    all.iter().copied().find(|v| name(*v).eq_ignore_ascii_case(text)).map(Some).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|v| name(*v)).collect();
        InputError::new(field, format!("\"{text}\" is none of {}", names.join(", ")))
    })
}

/// Number of yes among the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Share {
    /// Answers that say yes.
    pub yes: usize,
    /// Answers.
    pub of: usize,
}

impl Share {
    fn count(answers: impl Iterator<Item = bool>) -> Self {
        answers.fold(Self { yes: 0, of: 0 }, |s, yes| Self { yes: s.yes + usize::from(yes), of: s.of + 1 })
    }

    /// Share in percent; none without answers.
    pub fn percent(self) -> Option<f64> {
        (self.of > 0).then(|| 100.0 * self.yes as f64 / self.of as f64)
    }
}

/// Statistics of a population.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Population {
    /// Subjects who answered any question about their background.
    pub n: usize,
    /// Men and women.
    pub men: usize,
    /// Women.
    pub women: usize,
    /// Youngest and oldest, years.
    pub age_range: Option<(f64, f64)>,
    /// Age, years.
    pub age: Option<Summary>,
    /// Experience with computers, years.
    pub years: Option<Summary>,
    /// More than 20 hours a week at a computer.
    pub over_20_hours: Share,
    /// Familiar with simulation.
    pub simulation: Share,
    /// Familiar with engineering or physics.
    pub physics: Share,
}

/// Population of the thesis, as its section 6.3.3 states it; the answers of its single subjects are
/// not printed.
pub const THESIS_POPULATION: &str = "10 people, 8 men and 2 women, 23 to 45 years old, 9.9 years of computing on average, \
                                     all over 20 h a week; 30 % know simulation, 50 % engineering or physics";

/// Statistics of `all`; none where nobody answered.
pub fn population(all: &[Background]) -> Option<Population> {
    let given: Vec<&Background> = all.iter().filter(|b| !b.is_empty()).collect();
    if given.is_empty() {
        return None;
    }
    let ages: Vec<f64> = given.iter().filter_map(|b| b.age).collect();
    let years: Vec<f64> = given.iter().filter_map(|b| b.years).collect();
    let count = |sex| given.iter().filter(|b| b.sex == Some(sex)).count();
    let least = ages.iter().copied().reduce(f64::min);
    Some(Population {
        n: given.len(),
        men: count(Sex::Male),
        women: count(Sex::Female),
        age_range: least.zip(ages.iter().copied().reduce(f64::max)),
        age: summary(&ages),
        years: summary(&years),
        over_20_hours: Share::count(given.iter().filter_map(|b| b.hours.map(|h| h == WeeklyHours::Over20))),
        simulation: Share::count(given.iter().filter_map(|b| b.simulation)),
        physics: Share::count(given.iter().filter_map(|b| b.physics)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_population_like_that_of_the_thesis_has_its_statistics() {
        let of = |i: usize| {
            let texts = [
                ["23", "45", "30", "31", "28", "35", "40", "26", "29", "33"][i],
                if i < 8 { "male" } else { "Female" },
                ["5", "15", "8", "10", "9", "12", "14", "7", "9", "10"][i],
                ">20",
                if i < 3 { "yes" } else { "no" },
                if i.is_multiple_of(2) { "yes" } else { "no" },
            ];
            Background::parse(i.to_string(), texts).expect("valid")
        };
        let found = population(&(0..10).map(of).collect::<Vec<_>>()).expect("some");
        assert_eq!((found.n, found.men, found.women, found.age_range), (10, 8, 2, Some((23.0, 45.0))));
        assert!((found.years.expect("some").mean - 9.9).abs() < 1e-12);
        let shares = [found.over_20_hours, found.simulation, found.physics].map(|s| s.percent().expect("some"));
        assert_eq!(shares, [100.0, 30.0, 50.0]);
        assert_eq!(population(&[Background::default()]), None);
    }

    #[test]
    fn a_wrong_answer_names_its_column_and_what_is_asked() {
        let refused = |at: usize, text: &str| {
            let mut texts = ["", "", "", "", "", ""];
            texts[at] = text;
            Background::parse("a".to_owned(), texts).expect_err("not valid").to_string()
        };
        assert!(refused(0, "-3").contains("1 to 120") && refused(0, "NaN").contains("age"));
        assert!(refused(1, "m").contains("male, female"));
        assert!(refused(3, "20").contains("<1, 1-4, 4-10, 10-20, >20"));
        assert!(refused(4, "maybe").contains("yes, no"));
        let texts = ["31.5", "female", "12", "10-20", "yes", "N/A"];
        let read = Background::parse("a".to_owned(), texts).expect("valid");
        assert_eq!(read.texts(), ["31.5", "female", "12", "10-20", "yes", ""].map(str::to_owned));
    }
}
