//! Runs cases one by one, each under a time limit and a memory bound.

use crate::allocator;
use crate::files::{Place, temporary};
use rand::SeedableRng;
use rand::rngs::SmallRng;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// What went wrong with a case.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    /// Also one that the code caught itself.
    Panic(String),
    Hang,
    Memory {
        peak: usize,
    },
    /// Of the case's own checks.
    Wrong(String),
}

impl Failure {
    fn short(&self) -> String {
        format!("{self:?}").chars().take(500).collect()
    }

    /// Failures of one cause have one kind, mostly: the place of a panic, the first words of a message.
    fn kind(&self) -> String {
        match self {
            Self::Panic(message) => message.lines().next().unwrap_or_default().to_owned(),
            Self::Hang => "hang".to_owned(),
            Self::Memory { .. } => "memory".to_owned(),
            Self::Wrong(message) => message.chars().take(20).collect(),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Limits {
    pub time: Duration,
    /// Bytes held at once.
    pub memory: usize,
}

/// What every case of the fuzz targets gets. They start from files of kilobytes: of 130 000 cases the largest held 0.9 MB, and a
/// tile, which OpenEXR allows to be larger than its image, may have 16 MiB. 13 000 cases take some tens of seconds on a busy
/// machine, so 10 s for one are a hang.
pub const LIMITS: Limits = Limits { time: Duration::from_secs(10), memory: 32 << 20 };

pub type Check = std::result::Result<(), String>;

thread_local! {
    static WATCHED: Cell<bool> = const { Cell::new(false) };
    static PANICS: Cell<Option<String>> = const { Cell::new(None) };
}

/// Notes the panics of cases, those included that are caught on their way, and keeps them off the screen.
fn watch_panics() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        // The capture reader sets a hook of its own at its first frame; this one must come after it.
        crate::captures::read_one_frame();
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if WATCHED.get() {
                PANICS.set(Some(info.to_string()));
            } else {
                previous(info);
            }
        }));
    });
}

/// Runs one case on a thread of its own. A case that hangs leaves its thread behind.
pub fn run(limits: Limits, case: u64, check: impl FnOnce() -> Check + Send + 'static) -> Result<(), Failure> {
    watch_panics();
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        WATCHED.set(true);
        allocator::start(case);
        let outcome = catch_unwind(AssertUnwindSafe(check));
        let peak = allocator::peak();
        let panic = PANICS.take();
        let result = match (outcome, panic) {
            (_, Some(message)) => Err(Failure::Panic(message)),
            (Err(_), None) => Err(Failure::Panic("without a message".to_owned())),
            (Ok(_), None) if peak > limits.memory => Err(Failure::Memory { peak }),
            (Ok(checked), None) => checked.map_err(Failure::Wrong),
        };
        let _ = sender.send((result, peak));
    });
    match receiver.recv_timeout(limits.time) {
        Ok((result, peak)) => {
            LARGEST.with(|largest| largest.set(largest.get().max(peak)));
            result
        }
        Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(Failure::Hang),
    }
}

thread_local! {
    /// The largest peak of the cases that this test ran.
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn variable(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, expected a number")))
}

/// Runs `cases` cases of a target. `make` builds a case from random numbers in the place that it is given, and returns what it
/// is in words, and what to run.
pub fn fuzz<F>(target: &str, cases: u64, make: F)
where
    F: Fn(&mut SmallRng, &Place) -> (String, Box<dyn FnOnce() -> Check + Send>),
{
    let seed = variable("QUELL_FUZZ_SEED").unwrap_or(0);
    let cases = cases * variable("QUELL_FUZZ_CASES").unwrap_or(1);
    let only = variable("QUELL_FUZZ_ONLY");
    let mut failures: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let temporary = temporary();
    for case in only.map_or(0..cases, |case| case..case + 1) {
        // Each case has numbers of its own, so that it can be repeated alone.
        let mut random = SmallRng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ case);
        let (words, check) = make(&mut random, &temporary.place);
        let result = run(LIMITS, case, check);
        if only.is_some() {
            println!("{target}, seed {seed}, case {case}: {words}\n{result:?}");
        }
        if let Err(failure) = result {
            let words: String = words.chars().take(300).collect();
            let message = format!("seed {seed}, case {case}: {words}: {}", failure.short());
            failures.entry(failure.kind()).or_default().push(message);
        }
    }
    println!("{target}: at most {} bytes held", LARGEST.get());
    if only.is_some() {
        println!("its folder is kept: {}", temporary.keep().display());
    }
    let lines: Vec<String> =
        failures.values().map(|alike| format!("{} times, first {}", alike.len(), alike[0])).collect();
    assert!(lines.is_empty(), "{target}:\n{}", lines.join("\n"));
}
