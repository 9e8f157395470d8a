//! Reader of sheet files: order and content of the records.
//!
//! Units change from the file's to SI in the parser of the columns; see [`super`] for the format.

use crate::error::InputError;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{MAX_NODES, StructureKind};
use crate::scene::record_lines::{RecordLine, last_line, quoted, records};
use crate::scene::sht::{
    DAMPING, LayerCounts, MASS, MASS_FIELDS, MAX_SPRINGS, REST, STIFFNESS, SheetFile, SheetFileNode, SheetFileSpring,
};

/// Record letters in their order.
const ORDER: [&str; 7] = ["M", "S", "K", "*", "D", "C", "T"];

/// Read a .SHT text.
///
/// # Errors
/// The first fault, with its line: an unknown record, one out of order or missing, a wrong number
/// of fields, an invalid number or one out of range, a spring, corner or centre without its node,
/// dimensions that contradict the nodes, an unknown spring class or structure.
pub fn read_sht(text: &str) -> Result<SheetFile, InputError> {
    let mut reader = ShtReader::new();
    for record in records(text) {
        reader.record(&record)?;
    }
    if reader.stage + 1 < ORDER.len() {
        let missing = ORDER[(reader.stage + 1).max(3)];
        return Err(InputError::new(missing, "the file ends before this record").at_line(last_line(text)));
    }
    Ok(reader.sheet)
}

/// State of the reader.
struct ShtReader {
    sheet: SheetFile,
    layers: LayerCounts,
    marks: Vec<u32>,
    /// Position in [`ORDER`] of the last record.
    stage: usize,
}

impl ShtReader {
    fn new() -> Self {
        let sheet = SheetFile {
            masses: Vec::new(),
            springs: Vec::new(),
            corners: [0; 4],
            centre: 0,
            dimensions: [0; 3],
            damping: 0.0,
            structure: String::new(),
        };
        Self { sheet, layers: LayerCounts::default(), marks: Vec::new(), stage: 0 }
    }

    fn record(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        let Some(place) = ORDER.iter().position(|letter| *letter == record.letter) else {
            return Err(record.unknown(&ORDER.join(", ")));
        };
        // Lists may be long or, for springs, empty; from the end mark on each record comes once,
        // after the one before it.
        let in_order = if place <= 3 { place >= self.stage && self.stage < 3 } else { place == self.stage + 1 };
        if !in_order {
            let last = if self.sheet.masses.is_empty() { "the start" } else { ORDER[self.stage] };
            let problem = format!("out of place after {last}: the order is {}", ORDER.join(" "));
            return Err(record.error(record.letter, problem));
        }
        self.stage = place;
        match record.letter {
            "M" => self.mass(record),
            "S" => self.spring(record),
            "K" => self.mark(record),
            "*" => self.end_of_lists(record),
            "D" => self.dimensions(record),
            "C" => {
                record.expect_fields(1, "damping in %")?;
                self.sheet.damping = record.number(0, &DAMPING)?;
                Ok(())
            }
            _ => self.structure(record),
        }
    }

    fn mass(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(15, MASS_FIELDS)?;
        if self.sheet.masses.len() as u64 >= MAX_NODES {
            return Err(record.error("M", format!("the sheet has more than {MAX_NODES} masses")));
        }
        let mut numbers = [0.0; 13];
        for (index, (number, column)) in numbers.iter_mut().zip(&MASS).enumerate() {
            *number = record.number(index, column)?;
        }
        let layer = record.whole(13, "M.layer", MAX_NODES, "a layer")?;
        self.layers.add(layer).map_err(|problem| record.error("M.layer", problem))?;
        let border = record.whole(14, "M.border", 2, "a border flag")? == 1;
        self.sheet.masses.push(SheetFileNode::from_numbers(numbers, layer, border));
        Ok(())
    }

    fn spring(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(5, "kind a b stiffness rest")?;
        if self.sheet.springs.len() as u64 >= MAX_SPRINGS {
            return Err(record.error("S", format!("the sheet has more than {MAX_SPRINGS} springs")));
        }
        let word = record.field(0);
        let kind = SpringClass::from_name(word).ok_or_else(|| {
            let names = SpringClass::ALL.map(SpringClass::name).join(", ");
            record.error("S.kind", format!("no spring is of kind {}; there are {names}", quoted(word)))
        })?;
        let masses = self.sheet.masses.len() as u64;
        let (a, b) = (record.whole(1, "S.a", masses, "a mass")?, record.whole(2, "S.b", masses, "a mass")?);
        if a == b {
            return Err(record.error("S.b", format!("{b} is also the first end: the two ends must differ")));
        }
        let (stiffness, rest) = (record.number(3, &STIFFNESS)?, record.number(4, &REST)?);
        self.sheet.springs.push(SheetFileSpring { kind, a, b, stiffness, rest });
        Ok(())
    }

    fn mark(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(1, "index of a mass")?;
        if self.marks.len() == 5 {
            return Err(record.error("K", "a sixth K: there are 5, four corners and the centre"));
        }
        let mark = record.whole(0, "K.index", self.sheet.masses.len() as u64, "a mass")?;
        self.layers.check_mark(mark, &self.marks).map_err(|problem| record.error("K.index", problem))?;
        self.marks.push(mark);
        Ok(())
    }

    fn end_of_lists(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(0, "")?;
        let [a, b, c, d, centre] = self.marks[..] else {
            let problem =
                format!("{} K records before it: 5 are needed, four corners and the centre", self.marks.len());
            return Err(record.error("*", problem));
        };
        (self.sheet.corners, self.sheet.centre) = ([a, b, c, d], centre);
        Ok(())
    }

    fn dimensions(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(3, "nx layers nz")?;
        let size = |index, name| record.whole(index, name, MAX_NODES + 1, "a number of masses or layers");
        let dimensions = [size(0, "D.nx")?, size(1, "D.layers")?, size(2, "D.nz")?];
        self.layers.check_dimensions(dimensions).map_err(|problem| record.error("D", problem))?;
        self.sheet.dimensions = dimensions;
        Ok(())
    }

    fn structure(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(1, "name of the structure")?;
        let name = record.field(0);
        // The error of the table repeats the whole name; a long one is rejected before.
        if name.chars().count() > 40 {
            return Err(record.error("T", format!("no structure is named {}", quoted(name))));
        }
        if let Err(error) = name.parse::<StructureKind>() {
            return Err(record.error("T", error.problem));
        }
        self.sheet.structure = name.to_owned();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::record_lines::damage;
    use crate::scene::sht::tests::SMALL;
    use crate::scene::sht::write_sht;

    fn error(text: &str) -> String {
        read_sht(text).expect_err("bad").to_string()
    }

    /// Error of the small file with one text replaced.
    fn changed(from: &str, to: &str) -> String {
        assert!(SMALL.contains(from));
        error(&SMALL.replacen(from, to, 1))
    }

    #[test]
    fn faults_of_a_record_are_named_with_line_field_and_range() {
        assert!(error("Z\n").starts_with("line 1: unknown record \"Z\": a line starts with M, S, K, *, D, C, T or #"));
        assert!(changed(" 4 0 1\n", " 4 0\n").starts_with("line 1: M: takes 15 fields (ax ay az"));
        assert!(changed("M 0 0 0 0.575", "M 0 inf 0 0.575").starts_with("line 5: M.ay: \"inf\" is not a number"));
        assert_eq!(
            changed("0 4 0 1", "0 0 0 1"),
            "line 1: M.mass: \"0\" 1e-4 kg is outside 1e-8 to 10000000000 1e-4 kg"
        );
        assert!(changed("-98.1", "1e99").starts_with("line 2: M.ay: \"1e99\" cm/s² is outside"));
        assert_eq!(changed("4 0 1", "4 0 2"), "line 1: M.border: \"2\" is not a border flag, 0 to 1");
        assert_eq!(changed("4 0 1", "4 1 1"), "line 1: M.layer: 1 of the first mass must be 0");
        assert!(changed("0.5 1 1", "0.5 2 1").starts_with("line 5: M.layer: 2 follows 0"));
        assert!(changed("0.5 1 1", "0.5 -1 1").starts_with("line 5: M.layer: \"-1\" is not a layer"));
        assert!(
            changed("S z", "S y").starts_with("line 7: S.kind: no spring is of kind \"y\"; there are x, z, diagonal")
        );
        assert_eq!(changed("S z 0 2", "S z 0 5"), "line 7: S.b: \"5\" is not a mass, 0 to 4");
        assert_eq!(changed("S z 0 2", "S z -1 2"), "line 7: S.a: \"-1\" is not a mass, 0 to 4");
        assert!(changed("S z 0 2", "S z 2 2").starts_with("line 7: S.b: 2 is also the first end"));
        assert!(changed("60.5", "-1").starts_with("line 8: S.stiffness: \"-1\" 1e-3 N/m is outside 0 to"));
        assert!(changed("0.8193", "0").starts_with("line 8: S.rest: \"0\" cm is outside"));
        assert!(changed("S z 0 2 185", "S z 0 2").starts_with("line 7: S: takes 5 fields"));
        assert_eq!(changed("K 3", "K 5"), "line 12: K.index: \"5\" is not a mass, 0 to 4");
        assert_eq!(changed("K 3", "K 4"), "line 12: K.index: mass 4 is not in the bottom layer, which has 4 masses");
        assert!(changed("K 3", "K 1").starts_with("line 12: K.index: mass 1 is a corner already"));
        assert!(changed("C 11.5", "C -1").starts_with("line 16: C.damping: \"-1\" % is outside 0 to 1000 %"));
        assert!(
            changed("T samm", "T satin").starts_with("line 17: T: no structure is named \"satin\"; there are samm")
        );
        assert!(changed("T samm", "T a b").starts_with("line 17: T: takes 1 field (name"));
        assert!(changed("T samm", &format!("T {}", "a".repeat(9000))).len() < 100);
    }

    #[test]
    fn faults_of_the_whole_are_named_with_their_line() {
        assert_eq!(error(""), "line 1: *: the file ends before this record");
        assert_eq!(changed("T samm\n", ""), "line 16: T: the file ends before this record");
        assert_eq!(changed("*\nD 2 2 2\nC 11.5\nT samm\n", ""), "line 13: *: the file ends before this record");
        assert!(
            changed("T samm\n", "T samm\nK 1\n")
                .starts_with("line 18: K: out of place after T: the order is M S K * D C T")
        );
        assert!(changed("T samm\n", "T samm\nT samm\n").starts_with("line 18: T: out of place after T"));
        assert!(changed("D 2 2 2\nC 11.5", "C 11.5\nD 2 2 2").starts_with("line 15: C: out of place after *"));
        assert!(changed("K 0\n", "K 0\nS x 0 1 185 1\n").starts_with("line 10: S: out of place after K"));
        assert!(changed("*\n", "*\n*\n").starts_with("line 15: *: out of place after *"));
        assert!(changed("*\n", "K 1\n*\n").starts_with("line 14: K: a sixth K"));
        assert!(changed("K 3\nK 0\n", "K 3\n").starts_with("line 13: *: 4 K records before it: 5 are needed"));
        assert!(error("K 0\n").starts_with("line 1: K.index: \"0\" is not a mass: there is none"));
        assert!(error("*\n").starts_with("line 1: *: 0 K records"));
        assert!(error("T samm\n").starts_with("line 1: T: out of place after the start"));
        assert_eq!(changed("D 2 2 2", "D 3 2 2"), "line 15: D: 3 x 2 x 2 has 6 masses in layer 0, but 4 are there");
        assert_eq!(
            changed("D 2 2 2", "D 2 1 2"),
            "line 15: D: 2 x 1 x 2 contradicts the masses, which are in 2 layers"
        );
        assert!(changed("D 2 2 2", "D 1 2 4").contains("at least 2 x 1 x 2"));
        assert!(changed("D 2 2 2", "D 4294967295 2 4294967295").starts_with("line 15: D.nx: \"4294967295\" is not"));
        assert!(changed("D 2 2 2", "D 2 10000000 2").contains("2 x 10000000 x 2 contradicts"));
    }

    #[test]
    fn damaged_files_are_read_or_refused_but_never_panic() {
        let (mut good, mut bad) = (0, 0);
        damage::try_all(SMALL, 6000, |damaged| match read_sht(damaged) {
            Ok(read) => {
                assert_eq!(read.check(), Ok(()));
                assert_eq!(read_sht(&write_sht(&read)), Ok(read));
                good += 1;
            }
            Err(error) => {
                assert!(error.line.is_some() && !error.problem.is_empty());
                bad += 1;
            }
        });
        assert!(good > 100 && bad > 3000, "{good} read, {bad} refused");
    }
}
