//! Sheets and solver bodies of an island, borrowed for a step.

use crate::contact::SheetContact;
use crate::contact::solver::sheet_response::SheetResponse;
use crate::contact::solver_body::SolverBody;
use crate::parallel::*;
use crate::sheet::{Sheet, node_contact};

/// Sheets and solver bodies of an island, borrowed for a step.
pub(crate) struct IslandView<'a> {
    /// Sheets of the island. [`ContactSide::Sheet`] holds a position in this list.
    pub sheets: &'a mut [Sheet],
    /// Their contact states.
    pub contacts: &'a mut [SheetContact],
    /// Bodies of the island. [`ContactSide::Body`] holds a position in this list.
    pub solver_bodies: Vec<SolverBody>,
    /// Whether to work on several sheets in parallel.
    pub parallel: bool,
    /// Largest penetration between bodies that this step removes, m. Whatever lies on the bodies is
    /// lifted by as much.
    pub body_penetration: f64,
    /// Number of dynamic bodies that touch another dynamic body.
    pub stacked_bodies: usize,
}

impl IslandView<'_> {
    /// Sheet number `local` of the island.
    pub fn sheet(&self, local: u32) -> &Sheet {
        &self.sheets[local as usize]
    }

    /// Sheet number `local` of the island, mutable.
    pub fn sheet_mut(&mut self, local: u32) -> &mut Sheet {
        &mut self.sheets[local as usize]
    }

    /// Response to contact of sheet number `local` of the island.
    pub fn response(&self, local: u32) -> &SheetResponse {
        &self.contacts[local as usize].response
    }

    /// Sheet number `local` of the island with its response to contact, mutable.
    pub fn with_response(&mut self, local: u32) -> (&mut Sheet, &mut SheetResponse) {
        let index = local as usize;
        (&mut self.sheets[index], &mut self.contacts[index].response)
    }

    /// Call `work` as [`IslandView::for_each_sheet`] does, with the response of the sheet.
    pub fn each_response(&mut self, work: impl Fn(&mut Sheet, &mut SheetResponse) + Sync) {
        if self.parallel {
            let all = self.sheets.par_iter_mut().zip(self.contacts.par_iter_mut());
            all.for_each(|(sheet, contact)| work(sheet, &mut contact.response));
        } else {
            let all = self.sheets.iter_mut().zip(self.contacts.iter_mut());
            all.for_each(|(sheet, contact)| work(sheet, &mut contact.response));
        }
    }

    /// Number of independent parts: a single sheet and the bodies that touch only it count as one.
    /// With more parts, some contact changes state in almost every iteration.
    pub fn independent_parts(&self) -> usize {
        self.sheets.len() + self.stacked_bodies.saturating_sub(1)
    }

    /// Half the thickness of the thinnest sheet, to which tolerances of lengths refer, m.
    pub fn half_thickness(&self) -> f64 {
        self.sheets.iter().map(node_contact::half_thickness).fold(f64::INFINITY, f64::min)
    }

    /// Number of nodes of the island.
    pub fn nodes(&self) -> usize {
        self.sheets.iter().map(Sheet::node_count).sum()
    }

    /// Call `work` for every sheet of the island, in parallel if enabled. The work on one sheet
    /// must not depend on the others.
    pub fn for_each_sheet(&mut self, work: impl Fn(&mut Sheet) + Sync) {
        if self.parallel {
            self.sheets.par_iter_mut().for_each(&work);
        } else {
            self.sheets.iter_mut().for_each(work);
        }
    }
}
