//! Serialisation of a shell's bending.

use glam::DVec3;

use crate::elements::bending::Bending;
use crate::elements::{deserialise_matrices, serialise_matrices};
use crate::serialize::{ReadResult, StateReader, StateWriter};

impl Bending {
    /// Serialises the rates of curvature as a sparse list: a group of a grid has one or two of the
    /// three.
    pub(crate) fn serialise_rates(&self, to: &mut StateWriter) {
        let mut rates = Vec::with_capacity(3 * self.groups.len());
        self.groups.iter().for_each(|g| rates.extend_from_slice(&g.rate));
        to.sparse(&rates);
    }

    pub(crate) fn deserialise_rates(&mut self, from: &mut StateReader) -> ReadResult {
        let mut rates = vec![0.0; 3 * self.groups.len()];
        from.sparse(&mut rates)?;
        for (g, rate) in self.groups.iter_mut().zip(rates.chunks_exact(3)) {
            g.rate.copy_from_slice(rate);
        }
        Ok(())
    }

    /// Serialises stiffness and rest state. The values of the pairs are included, because each
    /// change of temperature or creep scale rounds them.
    pub(crate) fn serialise_law(&self, to: &mut StateWriter) {
        self.groups.iter().for_each(|g| to.number(g.softness));
        serialise_matrices(self.groups.iter().map(|g| &g.stiffness), to);
        self.pairs.iter().for_each(|p| to.number(p.value));
        to.flag(!self.rest.is_empty());
        for (rest, curl) in self.rest.iter().zip(&self.curl) {
            rest.iter().for_each(|r| to.sparse(&r.to_array()));
            to.number(*curl);
        }
        if let Some(rests) = &self.rest_curvature {
            rests.serialise(to);
        }
    }

    pub(crate) fn deserialise_law(&mut self, from: &mut StateReader) -> ReadResult {
        for group in &mut self.groups {
            group.softness = from.number()?;
        }
        deserialise_matrices(self.groups.iter_mut().map(|g| &mut g.stiffness), from)?;
        for pair in &mut self.pairs {
            pair.value = from.number()?;
        }
        let is_warm = from.flag()?;
        let count = if is_warm { self.groups.len() } else { 0 };
        self.rest.resize(count, [DVec3::ZERO; 3]);
        self.curl.resize(count, 0.0);
        for (rest, curl) in self.rest.iter_mut().zip(&mut self.curl) {
            for r in rest {
                let mut all = [0.0; 3];
                from.sparse(&mut all)?;
                *r = DVec3::from_array(all);
            }
            *curl = from.number()?;
        }
        if let Some(rests) = &mut self.rest_curvature {
            rests.deserialise(from)?;
        }
        self.sum_constant();
        Ok(())
    }
}
