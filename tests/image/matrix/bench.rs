//! The bench of the matrix in the flash image: the emulated board with the simulated joint on its
//! pins, and a client on its USART.

use dynamics::joint::Substitute;
use emulator::board::CLOCK_HZ;
use emulator::board_under_test::HaltedBoard;
use emulator::coupling::ImageSample;
use emulator::fault_injection::Injection;
use emulator::firmware::budgets::{INTERRUPT_INSTRUCTIONS, INTERRUPT_INSTRUCTIONS_ALONE};
use emulator::wire::EmulatedWire;
use experiments::matrix::{Bench, BenchSample, Situation, plan};
use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::simulated::{MotorWires, ShuntState};
use simulator::experiment::RunPlan;
use stiction::control::laws::Gains;
use stiction::link::FaultReport;
use stiction::{Fault, Tick};

use crate::common::firmware;
use crate::fault_injection::MS;

/// The control interrupt's budget, ns: from the read of the counter to the end, an instruction
/// being a cycle here.
pub const INTERRUPT_NS: u64 = ns(INTERRUPT_INSTRUCTIONS);

const fn ns(instructions: u32) -> u64 {
    instructions as u64 * 1_000_000_000 / CLOCK_HZ.get()
}

/// The reference of the converter that measures the supply, mV.
const SUPPLY_FULL_SCALE_MV: f64 = 3300.0;

/// The emulated board.
pub struct ImageBench {
    /// None while a session begins anew.
    client: Option<Client<EmulatedWire>>,
    last: Option<ImageSample>,
    detection: Option<ImageSample>,
}

impl ImageBench {
    /// Powers the board up.
    pub fn boot() -> Self {
        Self::with(&[], None)
    }

    /// Powers the board up with keys of the joint set.
    pub fn of(set: &[&str]) -> Self {
        Self::with(set, None)
    }

    /// Powers the board up with another joint on its pins.
    pub fn around(substitute: Option<Substitute>) -> Self {
        Self::with(&[], substitute)
    }

    fn with(set: &[&str], substitute: Option<Substitute>) -> Self {
        let plan = RunPlan { substitute, ..plan::<Self>("pd", set) };
        let wire = EmulatedWire::with(&firmware(), &plan).unwrap();
        Self { client: Some(Client::connect(wire).unwrap()), last: None, detection: None }
    }

    /// Connects after a reset.
    pub fn connect_anew(&mut self) {
        let wire = self.client.take().unwrap().end();
        self.client = Some(Client::connect(wire).unwrap());
    }

    /// Lets time pass, ns.
    pub fn wait(&mut self, ns: u64) {
        self.client().wire().board.pass(ns).unwrap();
    }

    /// Does something to the board.
    pub fn act<T: Send + 'static>(
        &mut self,
        act: impl for<'a> FnOnce(&mut HaltedBoard<'a>) -> T + Send + 'static,
    ) -> T {
        self.client().wire().board.act(act).unwrap()
    }

    pub fn log(&mut self) -> Vec<String> {
        self.act(|halted| halted.harness.log.lines.iter().map(|line| line.text.clone()).collect())
    }

    /// Returns the end of the last span of time in which the bridge was on, and the time, ns.
    pub fn off_and_now(&mut self) -> (u64, u64) {
        self.act(|halted| {
            (halted.harness.spans.on_ns.last().map_or(0, |[_, until]| *until), halted.now())
        })
    }

    /// Makes the gains that the law in the drive computes with not a number: Kd, and the inertia
    /// that `robust` has in its place. Only extreme parameters lead to a value that is not finite,
    /// so the servo's own copy is changed.
    pub fn spoil_gain(&mut self) {
        /// Kd of PD, of SRNF, and of the other laws, V s/deg.
        const KD: [f32; 3] = [0.15, 0.25, 0.17];
        let inertia = Gains::EXAMPLES.iter().find_map(|law| match law {
            Gains::Robust(gains) => Some(gains.inertia),
            _ => None,
        });
        let is_gain = move |word: u32| {
            let gain = f32::from_bits(word);
            KD.contains(&gain) || Some(gain) == inertia
        };
        let servo = firmware().variable("_servo");
        let spoiled = self.act(move |halted| {
            let mut spoiled = 0;
            for (address, length) in servo {
                let words = halted.words(address, length / 4).unwrap();
                for (index, _) in words.iter().enumerate().filter(|(_, word)| is_gain(**word)) {
                    halted.overwrite(address + 4 * index as u64, f32::NAN.to_bits()).unwrap();
                    spoiled += 1;
                }
            }
            spoiled
        });
        assert!(spoiled > 0, "the servo holds no gain");
    }
}

impl Bench for ImageBench {
    type Wire = EmulatedWire;
    // A slower PWM: it costs most of the emulator's time.
    const SET: &'static [&'static str] = &["drive.pwm_hz=2000"];
    const LATE: u32 = 1;

    fn client(&mut self) -> &mut Client<EmulatedWire> {
        self.client.as_mut().unwrap()
    }

    fn ticks(&mut self, count: u32) -> BenchSample {
        let mut sample = BenchSample { is_on: false, code: 0 };
        for _ in 0..count {
            let last = self.client().wire().board.samples(1).unwrap();
            let was_on = self.last.is_some_and(|last| last.bridge.is_on());
            sample = BenchSample { is_on: last.bridge.is_on(), code: last.code };
            if was_on && !sample.is_on {
                self.detection = Some(last);
            }
            self.last = Some(last);
        }
        sample
    }

    fn heard(&mut self, tick: u32) {
        if tick % 10 == 5 {
            self.client().status().unwrap();
        }
    }

    fn last_tick(&mut self) -> Tick {
        self.act(|halted| halted.last_tick().unwrap())
    }

    fn rewire(&mut self, wires: Wires) {
        self.act(move |halted| halted.rewire(wires));
    }

    fn jump(&mut self, counts: i32) {
        self.act(move |halted| halted.jump(counts));
    }

    fn supply(&mut self, of_full_scale: f64) {
        let millivolts = (of_full_scale * SUPPLY_FULL_SCALE_MV) as u32;
        self.act(move |halted| halted.board().supply(millivolts));
    }

    fn brake(&mut self, volts: f64) {
        self.act(move |halted| halted.plant().brake_v = volts);
    }

    fn motor(&mut self, wires: MotorWires, sensor: ShuntState) {
        self.act(move |halted| {
            halted.plant().motor_wires = wires;
            if let Some(shunt) = &mut halted.harness.coupling.plant.shunt {
                shunt.state = sensor;
            }
        });
    }

    fn position_deg(&mut self) -> f64 {
        self.act(|halted| halted.plant().position_deg())
    }

    fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.act(move |halted| halted.push(position_deg, velocity_deg_per_s));
    }

    fn assert_off_since_detection(&mut self, name: &str, law: &str) {
        let detection = self.detection.unwrap();
        let (off, now) = self.off_and_now();
        assert!(now > detection.at_ns + 400 * MS, "{name}");
        let alone = if law == "robust" { ns(INTERRUPT_INSTRUCTIONS_ALONE) } else { INTERRUPT_NS };
        assert!(off <= detection.at_ns + alone, "{name}: off at {off}, and {detection:?}");
    }

    fn assert_kept(&mut self, name: &str, report: &FaultReport) {
        let [(address, _)] = firmware().variable("KEPT")[..] else {
            panic!("KEPT is not in one piece")
        };
        // Magic, fault, place, value.
        let words = self.act(move |halted| halted.words(address, 4)).unwrap();
        let kept = (words[1], words[2], f32::from_bits(words[3]));
        assert_eq!(kept, (report.code.into(), report.tick, report.value), "{name}");
        // The converter's watchdog and the index report between two ticks, with the number of the
        // earlier one.
        let between = [Fault::OverCurrent, Fault::IndexDeviation];
        let early = u32::from(between.iter().any(|fault| report.code == *fault as u8));
        assert_eq!(Some(report.tick + early), self.detection.unwrap().clock, "{name}");
    }

    fn assert_kept_across_a_reset(&mut self, name: &str, fault: Fault) {
        let (off, _) = self.off_and_now();
        self.rewire(Wires::Sound);
        self.supply(0.5);
        self.brake(0.0);
        self.push(0.0, 0.0);
        self.ticks(2);
        // A second reset has no cause of its own. The fault is kept until a command clears it.
        let last = format!("reset by reset pin; last fault: {}", fault.describe());
        let reported = |bench: &mut Self| bench.log().iter().filter(|line| **line == last).count();
        let before = reported(self);
        let reset_now = |bench: &mut Self| {
            bench.act(|halted| halted.inject(Injection::Reset));
            bench.wait(200 * MS);
            bench.connect_anew();
        };
        let warm = self.client().status().unwrap().thermal_effort;
        for reset in 1..=2 {
            let name = format!("{name}, reset {reset}");
            reset_now(self);
            let status = self.client().status().unwrap();
            assert_eq!(status.fault.code, fault as u8, "{name}");
            // The motor cools for half a second of ten.
            let cooled = status.thermal_effort / warm;
            assert!(warm == 0.0 || (0.9..1.0).contains(&cooled), "{name}: {cooled} of {warm} V");
            assert!(self.client().arm().is_err(), "{name}");
            self.ticks(10);
            assert_eq!(self.off_and_now().0, off, "{name}: driven after the reset");
            assert_eq!(reported(self), before + reset, "{name}");
        }
        // The doubt in the encoder outlasts a command and the reset after it.
        self.client().clear().unwrap();
        self.ticks(2);
        reset_now(self);
        let status = self.client().status().unwrap();
        let doubts = matches!(fault, Fault::EncoderJump | Fault::Stall | Fault::EncoderReversed);
        assert_eq!((status.fault.code, status.is_encoder_in_doubt), (0, doubts), "{name}");
    }

    fn report(
        fault: Fault,
        what: &str,
        situation: Situation,
        cases: usize,
        [slowest, _]: [u32; 2],
    ) {
        print_row(fault, what, situation, cases, &format!("{slowest} ticks"));
    }
}

/// Prints a row for tests/evidence/reliability.md, as `cargo xtask reliability` reads it.
pub fn print_row(fault: Fault, what: &str, situation: Situation, cases: usize, slowest: &str) {
    let (fault, situation) = (fault.describe(), format!("{situation:?}").to_lowercase());
    println!(
        "reliability: image | fault={fault} | what={what} | situation={situation} | \
         cases={cases} | slowest={slowest}"
    );
}
