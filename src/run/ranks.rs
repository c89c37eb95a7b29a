//! Blocks on many machines.

use core::cell::Cell;
use core::fmt;
use std::time::Instant;

use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Root, Source};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Executor, Pass, Serial};
use crate::integrator::Integrator;

/// The ranks of an MPI job; the same bits as [`Serial`].
///
/// Every rank runs the same program and makes the same integrator. A pass goes in
/// rounds: in each, a rank computes a run of consecutive blocks, and the ranks'
/// subtrees are joined, pair by pair, along the tree that all blocks have. What
/// comes of a pass is told to all, so that every rank has the same answer at the
/// end, and a film the same image.
///
/// Rank 0 leads: its clock and its [`Cancel`](super::Cancel) end a run, looked at
/// between rounds, each of which takes about a tenth of a second, or a block; it
/// alone reads and writes a [`Checkpoint`](super::Checkpoint).
///
/// Each rank computes its blocks by an executor of its own: [`Serial`], with a rank
/// for each core, or `Threads`, with one for each machine.
///
/// # Failure
///
/// A sample that fails is the same error on all ranks. A rank that panics ends the
/// job while this value is dropped ([`abort`](Self::abort)), as the others would
/// wait for it for ever; the checkpoint before it is good. An error that a rank
/// alone meets, in the program around the run, has to do the same.
///
/// # Example
///
/// Under `mpirun -n 4`, all four print the same:
///
/// ```no_run
/// use estimand::prelude::*;
/// use estimand::run::Ranks;
///
/// let universe = mpi::initialize().ok_or("MPI has been initialised already")?;
/// let ranks = Ranks::new(universe.world(), Serial);
/// let estimator = Importance::new(|[x, y]| (x * y).exp(), UnitCube::<2>);
/// let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
/// let finished = run(&mut integrator, &ranks, &Stop::samples(100_000_000))?;
/// println!("{finished}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Ranks<X = Serial> {
    world: SimpleCommunicator,
    each: X,
    /// Blocks a rank gets in a round.
    share: Cell<u64>,
    traffic: Cell<Traffic>,
}

/// What a rank has sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Rounds it took part in.
    pub rounds: u64,
    /// Blocks that it computed.
    pub blocks: u64,
    /// Bytes of all subtrees that it sent, and of the largest.
    pub sent: u64,
    /// Of the largest of them.
    pub largest: u64,
    /// Bytes of the largest pass that was told to all.
    pub told: u64,
}

/// The seconds that a round is to take: so long that waiting for each other costs
/// little, so short that a limit of time is noticed.
const ROUND: f64 = 0.1;
/// MPI counts bytes by 32-bit numbers.
const MESSAGE: usize = 1 << 30;

impl<X> Ranks<X> {
    /// The ranks of `world`, each computing its blocks by `each`.
    pub fn new(world: SimpleCommunicator, each: X) -> Self {
        Self {
            world,
            each,
            share: Cell::new(1),
            traffic: Cell::default(),
        }
    }

    /// The number of this rank, from 0.
    pub fn rank(&self) -> u32 {
        self.world.rank().unsigned_abs()
    }

    /// How many there are.
    pub fn size(&self) -> u32 {
        self.world.size().unsigned_abs()
    }

    /// What this rank has sent so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    /// Ends the job on all ranks, and says why.
    pub fn abort(&self, why: &impl fmt::Display) -> ! {
        let (rank, size) = (self.rank(), self.size());
        eprintln!("rank {rank} of {size} ends the job: {why}");
        self.world.abort(1)
    }

    fn note(&self, change: impl FnOnce(&mut Traffic)) {
        let mut traffic = self.traffic.get();
        change(&mut traffic);
        self.traffic.set(traffic);
    }

    fn encode(&self, what: &impl Serialize) -> Vec<u8> {
        postcard::to_stdvec(what).unwrap_or_else(|error| self.abort(&error))
    }

    fn decode<T: DeserializeOwned>(&self, bytes: &[u8]) -> T {
        postcard::from_bytes(bytes).unwrap_or_else(|error| self.abort(&error))
    }

    fn send(&self, to: u32, bytes: &[u8]) {
        let to = self.world.process_at_rank(to.cast_signed());
        to.send(&(bytes.len() as u64));
        bytes.chunks(MESSAGE).for_each(|chunk| to.send(chunk));
    }

    fn receive(&self, from: u32) -> Vec<u8> {
        let from = self.world.process_at_rank(from.cast_signed());
        let (length, _) = from.receive::<u64>();
        let mut bytes = vec![0; length as usize];
        for chunk in bytes.chunks_mut(MESSAGE) {
            from.receive_into(chunk);
        }
        bytes
    }

    /// What rank 0 says.
    fn tell(&self, mut said: Vec<u8>) -> Vec<u8> {
        let leader = self.world.process_at_rank(0);
        let mut length = said.len() as u64;
        leader.broadcast_into(&mut length);
        said.resize(length as usize, 0);
        for chunk in said.chunks_mut(MESSAGE) {
            leader.broadcast_into(chunk);
        }
        said
    }

    /// Joins what consecutive ranks have: r with r + 1, then with r + 2, r + 4, …
    /// Rank 0 is left with all of it.
    fn join<P: crate::merge::Merge + Serialize + DeserializeOwned>(
        &self,
        mut part: Pass<P>,
    ) -> Option<Pass<P>> {
        let (rank, size) = (self.rank(), self.size());
        let steps = core::iter::successors(Some(1), |step| Some(2 * step));
        for step in steps.take_while(|step| *step < size) {
            if rank % (2 * step) == step {
                let bytes = self.encode(&part);
                let sent = bytes.len() as u64;
                self.note(|t| (t.sent, t.largest) = (t.sent + sent, t.largest.max(sent)));
                self.send(rank - step, &bytes);
                return None;
            }
            if rank + step < size {
                part.append(self.decode(&self.receive(rank + step)));
            }
        }
        Some(part)
    }
}

impl<I: Integrator, X: Executor<I>> Executor<I> for Ranks<X>
where
    I::Partial: Serialize + DeserializeOwned,
{
    fn pass(
        &self,
        integrator: &I,
        pass: &mut Pass<I::Partial>,
        blocks: u64,
        go_on: &(dyn Fn() -> bool + Sync),
    ) {
        let size = u64::from(self.size());
        let leads = self.rank() == 0;
        loop {
            let wanted = leads && !pass.has_ended() && pass.next() < blocks && go_on();
            let share = if wanted {
                // Rounds of equal length.
                let left = blocks - pass.next();
                let rounds = left.div_ceil(size * self.share.get().max(self.each.width()));
                left.div_ceil(size * rounds)
            } else {
                0
            };
            let (start, share): (u64, u64) =
                self.decode(&self.tell(self.encode(&(pass.next(), share))));
            if share == 0 {
                break;
            }
            let began = Instant::now();
            let from = (start + share * u64::from(self.rank())).min(blocks);
            let to = (from + share).min(blocks);
            let mut part = Pass::starting_at(from);
            self.each.pass(integrator, &mut part, to, &|| true);
            self.note(|t| (t.rounds, t.blocks) = (t.rounds + 1, t.blocks + to - from));
            if let Some(all) = self.join(part) {
                pass.append(all);
            }
            let seconds = began.elapsed().as_secs_f64() / share as f64;
            let fitting = (ROUND / seconds) as u64;
            self.share.set(fitting.clamp(1, 8 * share));
        }
        if size > 1 {
            let said = if leads { self.encode(pass) } else { Vec::new() };
            let told = self.tell(said);
            self.note(|t| t.told = t.told.max(told.len() as u64));
            if !leads {
                *pass = self.decode(&told);
            }
        }
    }

    fn leads(&self) -> bool {
        self.rank() == 0
    }

    fn agree(&self, said: Vec<u8>) -> Vec<u8> {
        self.tell(said)
    }
}

impl<X> Drop for Ranks<X> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.abort(&"it panicked; what was saved before is good");
        }
    }
}
