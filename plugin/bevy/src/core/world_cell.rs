//! The simulated world, or the task that steps it meanwhile.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};
use sheetwork::World as Sheets;

/// World with the time that its last task took.
struct Idle {
    world: Box<Sheets>,
    /// Wall-clock time and number of steps, until they are read.
    took: Option<(Duration, u64)>,
}

/// World that a task may step. Each access waits for the end of the step.
pub(super) struct WorldCell {
    /// Empty during a step.
    idle: OnceLock<Idle>,
    task: Mutex<Option<Task<Idle>>>,
}

impl WorldCell {
    pub fn new(world: Sheets) -> Self {
        let idle = OnceLock::from(Idle { world: Box::new(world), took: None });
        Self { idle, task: Mutex::new(None) }
    }

    /// Whether a step has begun whose end nothing has waited for.
    pub fn is_stepping(&self) -> bool {
        self.idle.get().is_none()
    }

    /// Let `work` step the world on Bevy's pool for asynchronous tasks; it returns the number of
    /// steps.
    pub fn begin(&mut self, work: impl FnOnce(&mut Sheets) -> u64 + Send + 'static) {
        self.wait();
        let Some(Idle { mut world, .. }) = self.idle.take() else { return };
        let step = move || {
            let start = Instant::now();
            let steps = work(&mut world);
            Idle { world, took: Some((start.elapsed(), steps)) }
        };
        if cfg!(target_arch = "wasm32") {
            // A browser's main thread cannot wait for a task.
            self.idle = OnceLock::from(step());
            return;
        }
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        *self.task.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(pool.spawn(async move { step() }));
    }

    /// Wall-clock time and number of steps of the last task, once.
    pub fn take_time(&mut self) -> Option<(Duration, u64)> {
        self.wait();
        self.idle.get_mut()?.took.take()
    }

    /// Wait for the end of the step.
    fn wait(&self) -> &Idle {
        self.idle.get_or_init(|| {
            let task = self.task.lock().unwrap_or_else(PoisonError::into_inner).take();
            block_on(task.unwrap_or_else(|| unreachable!("a world is idle or has a task, unless that has panicked")))
        })
    }
}

impl Deref for WorldCell {
    type Target = Sheets;

    fn deref(&self) -> &Sheets {
        &self.wait().world
    }
}

impl DerefMut for WorldCell {
    fn deref_mut(&mut self) -> &mut Sheets {
        self.wait();
        let idle = self.idle.get_mut();
        &mut idle.unwrap_or_else(|| unreachable!("the step has ended")).world
    }
}
