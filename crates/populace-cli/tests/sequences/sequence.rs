//! A sequence of calls, run on two crowds, and shortened if it fails.

use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use populace_testkit::Rng;

use crate::calls::{ALL, Call, CallKind};
use crate::draw::Draw;
use crate::fixture::Setup;
use crate::world::{MAX_MEMBERS, Outcome, World};

/// A sequence of calls.
#[derive(Clone, Debug)]
pub(crate) struct Sequence {
    seed: u64,
    calls: Vec<Call>,
    slots: usize,
    /// Whether numbers may be unusual.
    odd: bool,
}

impl Sequence {
    /// Creates the sequence of a seed. Every third seed has unusual numbers.
    pub(crate) fn new(seed: u64, count: usize) -> Self {
        let mut rng = Rng::new(seed);
        let total: usize = ALL.iter().map(|(_, weight)| weight).sum();
        let kind = |rng: &mut Rng| {
            let mut at = rng.below(total);
            let chosen = ALL.iter().find(|(_, weight)| {
                let is_chosen = at < *weight;
                at = at.saturating_sub(*weight);
                is_chosen
            });
            chosen.map_or(CallKind::Update, |(kind, _)| *kind)
        };
        let calls = (0..count).map(|_| Call { kind: kind(&mut rng), seed: rng.bits() }).collect();
        Self { seed, calls, slots: 1 + rng.below(8), odd: seed % 3 == 2 }
    }

    /// Reads a sequence: a byte for the slots and for unusual numbers, and 9 bytes for each call.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Self {
        let (first, calls) =
            bytes.split_first().map_or((0, bytes), |(first, calls)| (*first, calls));
        let call = |[kind, seed @ ..]: &[u8; 9]| Call {
            kind: ALL[usize::from(*kind) % ALL.len()].0,
            seed: u64::from_le_bytes(*seed),
        };
        let calls = calls.as_chunks().0.iter().map(call).collect();
        Self { seed: 0, calls, slots: 1 + usize::from(first / 2) % 8, odd: first % 2 == 1 }
    }

    /// Returns the bytes from which [`from_bytes`](Self::from_bytes) reads the sequence.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let kind = |kind: CallKind| ALL.iter().position(|(other, _)| *other == kind);
        let call = |call: &Call| {
            let kind = kind(call.kind).and_then(|at| u8::try_from(at).ok()).unwrap_or_default();
            [&[kind][..], &call.seed.to_le_bytes()].concat()
        };
        let first = 2 * (self.slots - 1) + usize::from(self.odd);
        let first = u8::try_from(first).expect("at most eight slots");
        [vec![first], self.calls.iter().flat_map(call).collect()].concat()
    }

    /// Makes the calls on two crowds and compares them. The error describes the fault.
    pub(crate) fn run(&self, setup: &Setup) -> Result<(), String> {
        catch_unwind(AssertUnwindSafe(|| self.compare(setup))).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(format!("panic: {}", text.unwrap_or("without a message")))
        })
    }

    fn compare(&self, setup: &Setup) -> Result<(), String> {
        let world = || {
            World::new(setup, self.slots, MAX_MEMBERS)
                .map_err(|error| format!("the crowd cannot be built: {error}"))
        };
        let mut worlds = [world()?, world()?];
        for (nth, call) in self.calls.iter().enumerate() {
            let at = |fault: &str| format!("call {nth}, {:?}: {fault}", call.kind);
            let [first, second] = [0, 1].map(|of| {
                let mut draw = Draw::new(call.seed, self.odd, false);
                call.kind.run(&mut worlds[of], &mut draw)
            });
            if first != second {
                return Err(at(&format!("the crowds return {first:?} and {second:?}")));
            }
            if call.kind == CallKind::Update && first == Some(Outcome::Done) {
                self.compare_palettes(&mut worlds).map_err(|fault| at(&fault))?;
            }
        }
        Ok(())
    }

    fn compare_palettes(&self, worlds: &mut [World; 2]) -> Result<(), String> {
        let [first, second] = worlds;
        let read =
            |world: &mut World| world.palettes().map_err(|error| format!("no palettes: {error}"));
        let (first, second) = (read(first)?, read(second)?);
        for (member, (first, second)) in first.iter().zip(&second).enumerate() {
            let number = |bits: u32| f32::from_bits(bits);
            if let Some(at) = first.iter().zip(second).position(|(a, b)| a != b) {
                let (a, b) = (number(first[at]), number(second[at]));
                return Err(format!(
                    "number {at} of the palette of member {member} is {a} and {b}"
                ));
            }
            if let Some(at) = first.iter().position(|bits| !number(*bits).is_finite()) {
                return Err(format!(
                    "number {at} of the palette of member {member} is {}",
                    number(first[at])
                ));
            }
        }
        Ok(())
    }

    /// Removes ever smaller parts, as long as the sequence still fails.
    fn shortened(&self, setup: &Setup) -> Self {
        let fails =
            |calls: &[Call]| Self { calls: calls.to_vec(), ..self.clone() }.run(setup).is_err();
        let mut calls = self.calls.clone();
        let mut part = calls.len().div_ceil(2);
        while part > 0 {
            let mut first = 0;
            while first < calls.len() {
                let mut without = calls.clone();
                without.drain(first..(first + part).min(calls.len()));
                if fails(&without) {
                    calls = without;
                } else {
                    first += part;
                }
            }
            part /= 2;
        }
        Self { calls, ..self.clone() }
    }

    /// Shortens a failing sequence and formats it.
    pub(crate) fn report(&self, setup: &Setup, fault: &str) -> String {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let short = self.shortened(setup);
        let last = short.run(setup).err().unwrap_or_default();
        std::panic::set_hook(hook);
        let Self { seed, slots, .. } = self;
        let mut text = format!(
            "seed {seed} on {} with {slots} slots: {fault}\nshortened to {} calls: {last}\n",
            setup.name,
            short.calls.len()
        );
        text.push_str(&short.format_calls(setup));
        text
    }

    /// Formats the calls with their arguments and results.
    fn format_calls(&self, setup: &Setup) -> String {
        let mut text = String::new();
        let Ok(mut world) = World::new(setup, self.slots, MAX_MEMBERS) else { return text };
        for call in &self.calls {
            let mut draw = Draw::new(call.seed, self.odd, true);
            let run = catch_unwind(AssertUnwindSafe(|| call.kind.run(&mut world, &mut draw)));
            let answer = match run {
                Ok(Some(Outcome::Done)) => "done".to_owned(),
                Ok(Some(Outcome::Refused(reason))) => format!("refused: {reason}"),
                Ok(Some(Outcome::Read(bits))) => format!("{} numbers", bits.len()),
                Ok(None) => "not applicable".to_owned(),
                Err(_) => "panics".to_owned(),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {:?} {{ {} }}: {answer}", call.kind, draw.recorded());
        }
        text
    }
}
