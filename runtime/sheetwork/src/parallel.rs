//! Parallel iterators and thread pools: rayon's with the feature `parallel`, sequential ones of the
//! same interface without it. Results are bit-equal: no reduction depends on the number of threads.

#[cfg(feature = "parallel")]
mod threads {
    pub(crate) use rayon::join;
    pub(crate) use rayon::prelude::*;

    use crate::error::InputError;

    /// Pool of threads that step islands.
    pub(crate) struct Pool(rayon::ThreadPool);

    impl Pool {
        /// Pool of `threads` threads.
        ///
        /// # Errors
        /// When the system refuses to start the threads.
        pub fn new(threads: usize) -> Result<Self, InputError> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map(Self).map_err(|e| InputError::new("threads", e.to_string()))
        }

        /// Run `work` on the pool.
        pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
            self.0.install(work)
        }
    }
}

#[cfg(not(feature = "parallel"))]
mod threads {
    use crate::error::InputError;

    /// Run both closures, the first one first.
    pub(crate) fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
        (a(), b())
    }

    /// Sequential stand-in of a parallel iterator over a slice.
    pub(crate) trait SequentialSlice<T> {
        fn par_iter(&self) -> std::slice::Iter<'_, T>;
        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T>;
        fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T>;
    }

    impl<T> SequentialSlice<T> for [T] {
        fn par_iter(&self) -> std::slice::Iter<'_, T> {
            self.iter()
        }

        fn par_iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
            self.iter_mut()
        }

        fn par_chunks(&self, size: usize) -> std::slice::Chunks<'_, T> {
            self.chunks(size)
        }
    }

    /// Sequential stand-in of the methods that only parallel iterators have.
    pub(crate) trait SequentialIterator: Iterator + Sized {
        fn with_min_len(self, _length: usize) -> Self {
            self
        }

        fn unzip_into_vecs<A, B>(self, left: &mut Vec<A>, right: &mut Vec<B>)
        where
            Self: Iterator<Item = (A, B)>,
        {
            left.clear();
            right.clear();
            for (a, b) in self {
                left.push(a);
                right.push(b);
            }
        }
    }

    impl<I: Iterator> SequentialIterator for I {}

    /// Stand-in of a pool: runs everything on the thread of the caller.
    pub(crate) struct Pool;

    impl Pool {
        pub fn new(_threads: usize) -> Result<Self, InputError> {
            Ok(Self)
        }

        pub fn install<T>(&self, work: impl FnOnce() -> T) -> T {
            work()
        }
    }
}

pub(crate) use threads::*;
