//! Who computes the blocks of a pass.

use core::ops::ControlFlow;

use crate::integrator::Integrator;
use crate::merge::{Merge, Tree};

/// Computes the blocks of a pass, each of which is merged, in its place, along
/// the [`Tree`].
///
/// The integrator is a parameter, so that each executor asks for the bounds
/// that it needs.
pub trait Executor<I: Integrator> {
    /// Adds the blocks from [`pass.next()`](Pass::next) to `blocks` of the planned
    /// pass to those that it has, no new one once `go_on` says no or the pass has
    /// [ended](Pass::has_ended).
    fn pass(
        &self,
        integrator: &I,
        pass: &mut Pass<I::Partial>,
        blocks: u64,
        go_on: &(dyn Fn() -> bool + Sync),
    );

    /// How many blocks it computes at a time. Provided: one.
    fn width(&self) -> u64 {
        1
    }

    /// Whether this process is the one that saves; the others of a run on several
    /// have the same answer, and write nothing. Provided: there are no others.
    fn leads(&self) -> bool {
        true
    }

    /// Tells all processes what the leading one says: every one calls this, and
    /// goes by what comes back. Provided: there are no others.
    fn agree(&self, said: Vec<u8>) -> Vec<u8> {
        said
    }
}

/// The blocks of a pass that have been computed so far: the first ones, merged.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pass<P> {
    tree: Tree<P>,
    ended: bool,
}

impl<P> Default for Pass<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P> Pass<P> {
    /// A pass of which there is no block yet.
    #[must_use]
    pub const fn new() -> Self {
        Self::starting_at(0)
    }

    /// Part of a pass: blocks from number `start` on.
    #[must_use]
    pub const fn starting_at(start: u64) -> Self {
        Self {
            tree: Tree::starting_at(start),
            ended: false,
        }
    }

    /// The number of the block that is to come.
    #[must_use]
    pub const fn next(&self) -> u64 {
        self.tree.end()
    }

    /// Whether the last block ended the pass.
    #[must_use]
    pub const fn has_ended(&self) -> bool {
        self.ended
    }
}

impl<P: Merge> Pass<P> {
    /// Adds the next block; nothing once the pass has ended.
    pub fn push(&mut self, block: ControlFlow<P, P>) {
        if self.ended {
            return;
        }
        self.ended = block.is_break();
        match block {
            ControlFlow::Break(partial) | ControlFlow::Continue(partial) => {
                self.tree.push(partial);
            }
        }
    }

    /// Adds the blocks that follow; nothing once the pass has ended.
    pub fn append(&mut self, right: Self) {
        if self.ended {
            return;
        }
        self.tree.append(right.tree);
        self.ended = right.ended;
    }

    /// All of them; `None` if there was none.
    #[must_use]
    pub fn finish(self) -> Option<P> {
        self.tree.finish()
    }
}

/// One block after the other, on the calling thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Serial;

impl<I: Integrator> Executor<I> for Serial {
    fn pass(
        &self,
        integrator: &I,
        pass: &mut Pass<I::Partial>,
        blocks: u64,
        go_on: &(dyn Fn() -> bool + Sync),
    ) {
        while pass.next() < blocks && !pass.has_ended() && go_on() {
            pass.push(integrator.block(pass.next()));
        }
    }
}

#[cfg(feature = "parallel")]
pub use threads::Threads;

#[cfg(feature = "parallel")]
mod threads {
    use std::collections::BTreeMap;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
    use std::sync::{Mutex, PoisonError};

    use super::{ControlFlow, Executor, Integrator, Pass, Serial};

    /// The threads of the current rayon pool; the same bits as [`Serial`].
    ///
    /// Blocks are handed out in order, so that those which are done when a run
    /// is interrupted are the first ones and none is lost. For another number
    /// of threads, call [`run`](crate::run::run) inside
    /// `rayon::ThreadPool::install`.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Threads;

    /// Ends the pass on all threads if the block of one panics.
    struct EndOnPanic<'a>(&'a AtomicBool);

    impl Drop for EndOnPanic<'_> {
        fn drop(&mut self) {
            if std::thread::panicking() {
                self.0.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Blocks that were finished before one that comes before them.
    struct Arrivals<'a, P> {
        pass: &'a mut Pass<P>,
        early: BTreeMap<u64, ControlFlow<P, P>>,
    }

    impl<I: Integrator + Sync> Executor<I> for Threads
    where
        I::Partial: Send,
    {
        fn pass(
            &self,
            integrator: &I,
            pass: &mut Pass<I::Partial>,
            blocks: u64,
            go_on: &(dyn Fn() -> bool + Sync),
        ) {
            let threads = rayon::current_num_threads() as u64;
            let left = blocks.saturating_sub(pass.next());
            if threads.min(left) < 2 {
                return Serial.pass(integrator, pass, blocks, go_on);
            }
            let next = AtomicU64::new(pass.next());
            let ended = AtomicBool::new(pass.has_ended());
            let arrivals = Mutex::new(Arrivals {
                pass,
                early: BTreeMap::new(),
            });
            let work = || {
                let _guard = EndOnPanic(&ended);
                while !ended.load(Ordering::Relaxed) && go_on() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= blocks {
                        break;
                    }
                    let block = integrator.block(index);
                    if block.is_break() {
                        ended.store(true, Ordering::Relaxed);
                    }
                    let mut guard = arrivals.lock().unwrap_or_else(PoisonError::into_inner);
                    let Arrivals { pass, early } = &mut *guard;
                    early.insert(index, block);
                    while let Some(block) = early.remove(&pass.next()) {
                        pass.push(block);
                        if pass.has_ended() {
                            early.clear();
                        }
                    }
                }
            };
            rayon::scope(|scope| {
                for _ in 0..threads.min(left) {
                    scope.spawn(|_| work());
                }
            });
        }

        fn width(&self) -> u64 {
            rayon::current_num_threads() as u64
        }
    }
}
