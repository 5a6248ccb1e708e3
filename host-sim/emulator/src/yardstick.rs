//! Counts the instructions of control steps that are not the firmware's, as those of its tick: in
//! the image of `xtask/yardstick`, which runs nothing else.

use std::collections::VecDeque;
use std::path::Path;

use rigless::emulator::{Driver, Error as HostError, Host, Settled, Start, Stop};
use rigless::image::Image;
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, FittedParts};
use super::probe::{Counter, Span};
use crate::firmware::Code;
use files::error::Error;

/// Steps of the image: name in the results, and path in the image.
pub const STEPS: [(&str, &str); 5] = [
    ("pid-crate", "yardstick::steps::pid_step"),
    ("pd+tanhf", "yardstick::steps::pd_tanh_step"),
    ("face-robust", "yardstick::face::robust_step"),
    ("face-monitor", "yardstick::face::monitors_step"),
    ("face-pd-srnf", "yardstick::face::pd_step"),
];
const INPUT: &str = "yardstick::steps::INPUT";
/// Interval at which the end of the run is checked, ns.
const LOOK_EVERY_NS: u64 = 1_000_000;
/// Time per sample that counts as a hang, ns: twenty times as long as a step, which takes well
/// under a microsecond.
const LIMIT_NS: u64 = 20_000;

/// Returns the instructions of each call of each step, fed with the set points and positions in
/// `samples` (deg).
///
/// # Errors
/// Returns an error if the image is not that of the yardsticks, or hangs.
pub fn count(
    path: &Path,
    elf: &[u8],
    samples: &[[f32; 2]],
) -> Result<[Vec<u32>; STEPS.len()], Error> {
    let trouble = |why: String| Error::Emulator(format!("{}: {why}", path.display()));
    let code = Code::read(path, elf)?;
    let counter = |path| Ok::<_, Error>(Counter::new(Span::called(&code, code.function(path)?)?));
    let [(_, first), ..] = STEPS;
    let counters = STEPS.iter().map(|(_, path)| counter(path)).collect::<Result<Vec<_>, _>>()?;
    let feeder = Feeder {
        counters,
        first: code.function(first)?.address.into(),
        counts: STEPS.map(|_| Vec::new()),
        input: code.variable(INPUT)?.into(),
        waiting: samples.iter().copied().collect(),
        enough: samples.len() + 1,
        error: None,
    };
    let images =
        [Image::new(path, elf.to_vec(), None).map_err(|error| trouble(error.to_string()))?];
    let board = Box::new(EmulatedBoard::new(FittedParts::default())?);
    let session =
        Session::new(board, 0, VirtualNanos(0)).map_err(|error| trouble(error.to_string()))?;
    let finished = rigless::emulator::run(session, &Start::new(&images), feeder)
        .map_err(|error| trouble(error.to_string()))?;
    let Feeder { counts, error, enough, .. } = finished.driver;
    match error {
        Some(error) => Err(trouble(error.to_string())),
        None if counts.iter().all(|counts| counts.len() >= enough) => {
            // The first call came before the first sample.
            Ok(counts.map(|counts| counts.into_iter().take(enough).skip(1).collect()))
        }
        None => Err(trouble("the image does not call its steps".into())),
    }
}

struct Feeder {
    counters: Vec<Counter>,
    /// Address of the first step: when it starts, the image has read its input.
    first: u64,
    counts: [Vec<u32>; STEPS.len()],
    input: u64,
    waiting: VecDeque<[f32; 2]>,
    /// Required number of calls of each step.
    enough: usize,
    error: Option<HostError>,
}

impl Feeder {
    /// Writes the input that the image reads before its next call.
    fn feed(&mut self, host: &mut dyn Host) -> Result<(), HostError> {
        let Some(sample) = self.waiting.pop_front() else { return Ok(()) };
        host.write(self.input, Width::W32, sample[0].to_bits().into())?;
        host.write(self.input + 4, Width::W32, sample[1].to_bits().into())
    }
}

impl Driver<EmulatedBoard> for Feeder {
    fn on_settled(
        &mut self,
        _: &mut Session<EmulatedBoard>,
        host: &mut dyn Host,
        settled: Settled,
    ) {
        let Settled::Hit(hit) = settled else { return };
        for (counter, counts) in self.counters.iter_mut().zip(&mut self.counts) {
            counts.extend(counter.hit(&hit));
        }
        if hit.address == self.first
            && let Err(error) = self.feed(host)
        {
            self.error.get_or_insert(error);
        }
    }

    fn on_stop(
        &mut self,
        _: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if stop.at.0 == 0
            && let Err(error) = self.counters.iter().try_for_each(|counter| counter.attach(host))
        {
            self.error.get_or_insert(error);
        }
        let over = self.counts.iter().all(|counts| counts.len() >= self.enough)
            || stop.at.0 > self.enough as u64 * LIMIT_NS + LOOK_EVERY_NS
            || self.error.is_some();
        (!over).then_some(VirtualNanos(stop.at.0 + LOOK_EVERY_NS))
    }
}
