//! Vectors as a structure of arrays, so that loops over one coordinate are contiguous in memory.

use glam::DVec3;

/// One vector per node, stored by coordinate. The three arrays have equal lengths.
#[derive(Debug, Default, PartialEq)]
pub struct Vectors {
    /// First coordinates.
    pub x: Vec<f64>,
    /// Second coordinates.
    pub y: Vec<f64>,
    /// Third coordinates.
    pub z: Vec<f64>,
}

impl Clone for Vectors {
    fn clone(&self) -> Self {
        Self { x: self.x.clone(), y: self.y.clone(), z: self.z.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.y.clone_from(&other.y);
        self.z.clone_from(&other.z);
    }
}

impl Vectors {
    /// `n` zero vectors.
    pub fn zeros(n: usize) -> Self {
        Self { x: vec![0.0; n], y: vec![0.0; n], z: vec![0.0; n] }
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is no vector.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Vector `i`. Panics for an index out of range.
    #[inline]
    pub fn get(&self, i: usize) -> DVec3 {
        DVec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Set vector `i`. Panics for an index out of range.
    #[inline]
    pub fn set(&mut self, i: usize, v: DVec3) {
        self.x[i] = v.x;
        self.y[i] = v.y;
        self.z[i] = v.z;
    }

    /// Add `d` to vector `i`. Panics for an index out of range.
    #[inline]
    pub(crate) fn add(&mut self, i: usize, d: DVec3) {
        self.set(i, self.get(i) + d);
    }

    /// Append a vector.
    pub fn push(&mut self, v: DVec3) {
        self.x.push(v.x);
        self.y.push(v.y);
        self.z.push(v.z);
    }

    /// All vectors in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// The three arrays.
    #[inline]
    pub fn axes(&self) -> [&[f64]; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// The three arrays, mutable.
    #[inline]
    pub fn axes_mut(&mut self) -> [&mut [f64]; 3] {
        [&mut self.x, &mut self.y, &mut self.z]
    }

    /// Copy all vectors of `other`, which must have the same length.
    pub fn copy_from(&mut self, other: &Self) {
        for (to, from) in self.axes_mut().into_iter().zip(other.axes()) {
            to.copy_from_slice(from);
        }
    }

    /// Set every component to zero.
    pub fn clear(&mut self) {
        for axis in self.axes_mut() {
            axis.fill(0.0);
        }
    }

    /// Compute self += h · d, component by component.
    #[inline]
    pub fn add_scaled(&mut self, h: f64, d: &Self) {
        for (to, from) in self.axes_mut().into_iter().zip(d.axes()) {
            for (t, f) in to.iter_mut().zip(from) {
                *t += h * f;
            }
        }
    }

    /// Compute self = a + h · d, component by component.
    #[inline]
    pub fn set_sum(&mut self, a: &Self, h: f64, d: &Self) {
        for ((to, a), d) in self.axes_mut().into_iter().zip(a.axes()).zip(d.axes()) {
            for ((t, a), d) in to.iter_mut().zip(a).zip(d) {
                *t = a + h * d;
            }
        }
    }

    /// Set to `(a - b) / h`.
    pub(crate) fn set_rate(&mut self, a: &Self, b: &Self, h: f64) {
        for ((to, a), b) in self.axes_mut().into_iter().zip(a.axes()).zip(b.axes()) {
            for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
                *to = (a - b) / h;
            }
        }
    }

    /// Compute self = p · a + q · b, component by component.
    pub fn blend(&mut self, p: f64, a: &Self, q: f64, b: &Self) {
        for ((to, a), b) in self.axes_mut().into_iter().zip(a.axes()).zip(b.axes()) {
            for ((t, a), b) in to.iter_mut().zip(a).zip(b) {
                *t = p * a + q * b;
            }
        }
    }

    /// Compute self = s · self + h · d, component by component.
    pub fn scale_and_add(&mut self, s: f64, h: f64, d: &Self) {
        for (to, from) in self.axes_mut().into_iter().zip(d.axes()) {
            for (t, f) in to.iter_mut().zip(from) {
                *t = s * *t + h * f;
            }
        }
    }

    /// Largest squared length; infinite if any component is NaN.
    pub fn max_squared(&self) -> f64 {
        let mut largest = 0.0_f64;
        for ((x, y), z) in self.x.iter().zip(&self.y).zip(&self.z) {
            let s = x * x + y * y + z * z;
            // `f64::max` would ignore NaN; the negated comparison is true for it.
            #[allow(clippy::neg_cmp_op_on_partial_ord)]
            if !(s <= largest) {
                largest = if s.is_nan() { f64::INFINITY } else { s };
            }
        }
        largest
    }

    /// Lower and upper corner of the bounding box of all vectors; `None` without a vector.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        if self.is_empty() {
            return None;
        }
        let mut low = self.get(0);
        let mut high = low;
        for p in self.iter() {
            low = low.min(p);
            high = high.max(p);
        }
        Some((low, high))
    }
}
