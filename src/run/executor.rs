//! Who computes the blocks of a pass.

use core::ops::ControlFlow;

use crate::integrator::Integrator;
use crate::merge::{Merge, Tree};

/// Computes the blocks of a pass and merges them, in their order, along the
/// [`Tree`].
///
/// The integrator is a parameter, so that each executor asks for the bounds
/// that it needs.
pub trait Executor<I: Integrator> {
    /// Computes blocks 0 .. `blocks` of the planned pass, no new one once
    /// `go_on` says no.
    fn pass(
        &self,
        integrator: &I,
        blocks: u64,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Pass<I::Partial>;
}

/// What came of a pass.
#[derive(Clone, Debug)]
pub struct Pass<P> {
    /// Its first blocks, merged; `None` if there was none.
    pub merged: Option<P>,
    /// How many they are.
    pub blocks: u64,
}

/// One block after the other, on the calling thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Serial;

impl<I: Integrator> Executor<I> for Serial {
    fn pass(
        &self,
        integrator: &I,
        blocks: u64,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Pass<I::Partial> {
        let mut prefix = Prefix::new();
        for index in 0..blocks {
            if prefix.ended || !go_on() {
                break;
            }
            prefix.push(integrator.block(index));
        }
        prefix.finish()
    }
}

/// The blocks that have been merged so far: always the first ones.
struct Prefix<P> {
    tree: Tree<P>,
    blocks: u64,
    /// Whether the last of them ended the pass.
    ended: bool,
}

impl<P: Merge> Prefix<P> {
    const fn new() -> Self {
        Self {
            tree: Tree::new(),
            blocks: 0,
            ended: false,
        }
    }

    /// Adds the next block; nothing once the pass has ended.
    fn push(&mut self, block: ControlFlow<P, P>) {
        if self.ended {
            return;
        }
        self.blocks += 1;
        self.ended = block.is_break();
        match block {
            ControlFlow::Break(partial) | ControlFlow::Continue(partial) => {
                self.tree.push(partial);
            }
        }
    }

    fn finish(self) -> Pass<P> {
        Pass {
            merged: self.tree.finish(),
            blocks: self.blocks,
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

    use super::{ControlFlow, Executor, Integrator, Pass, Prefix, Serial};

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
    struct Arrivals<P> {
        prefix: Prefix<P>,
        early: BTreeMap<u64, ControlFlow<P, P>>,
    }

    impl<I: Integrator + Sync> Executor<I> for Threads
    where
        I::Partial: Send,
    {
        fn pass(
            &self,
            integrator: &I,
            blocks: u64,
            go_on: &(dyn Fn() -> bool + Sync),
        ) -> Pass<I::Partial> {
            let threads = rayon::current_num_threads() as u64;
            if threads.min(blocks) < 2 {
                return Serial.pass(integrator, blocks, go_on);
            }
            let next = AtomicU64::new(0);
            let ended = AtomicBool::new(false);
            let arrivals = Mutex::new(Arrivals {
                prefix: Prefix::new(),
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
                    let Arrivals { prefix, early } = &mut *guard;
                    early.insert(index, block);
                    while let Some(block) = early.remove(&prefix.blocks) {
                        prefix.push(block);
                        if prefix.ended {
                            early.clear();
                        }
                    }
                }
            };
            rayon::scope(|scope| {
                for _ in 0..threads.min(blocks) {
                    scope.spawn(|_| work());
                }
            });
            arrivals
                .into_inner()
                .unwrap_or_else(PoisonError::into_inner)
                .prefix
                .finish()
        }
    }
}
