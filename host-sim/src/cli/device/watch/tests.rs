use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::style::Color;
use stiction::link::{FaultReport, Sample, StateCode, Status, WireErrors};

use super::keys::{WatchFlow, press};
use super::model::{WatchSample, WatchedDevice, subscribed};
use super::view::draw;
use files::error::Error;
use simulator::device::client::Client;
use simulator::device::shown_current::ShownCurrent;
use simulator::device::signals::Signals;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SIMULATED, SimulatedWire, Wire};
use simulator::experiment::{Document, Experiment};

fn status() -> Status {
    Status {
        state: StateCode::Armed,
        fault: FaultReport::default(),
        faults: 0,
        clock: 5000,
        sample_time: 0.01,
        position: 200,
        resolution: 0.01,
        at_rest: true,
        wound_up: false,
        thermal_effort: 0.5,
        motor_temperature: None,
        unsaved: false,
        is_damaged: false,
        oscillates: false,
        saves: 1,
        bad_frames: 0,
        dropped: 0,
        has_brown_out: true,
        wire: WireErrors::default(),
        crystal_not_measured: false,
        gave_up: false,
        is_encoder_in_doubt: false,
        is_referenced: true,
        is_testing: false,
        has_failed_test: false,
        load_angle: None,
        index_passes: 0,
        index_deviation: 0,
    }
}

/// A set point of 5.005 deg and a position of `counts` x 0.01 deg; the effort is 2.75 V, limited to
/// 2.5 V.
fn sample(clock: u32, counts: i32, state: u32) -> Sample {
    let value = |name| match name {
        "counts" => counts as u32,
        "reference_counts" => 500,
        "reference_fraction_counts" => 0.5f32.to_bits(),
        "error_deg" => 1.2345f32.to_bits(),
        "velocity_deg_per_s" => (-6.5f32).to_bits(),
        "v_pd_v" => 2.5f32.to_bits(),
        "v_c_v" => 0.25f32.to_bits(),
        "v_v" => 2.75f32.to_bits(),
        "v_applied_v" => 2.5f32.to_bits(),
        "current_a" => 1.1f32.to_bits(),
        "code" => 563,
        "compare" => 2000,
        "reverse" => 1,
        "status" => state | 1 << 16,
        other => panic!("{other}"),
    };
    let signals = Signals::of_core();
    let mask = signals.mask(subscribed());
    let sent = signals.names().filter(|name| subscribed().any(|one| one == *name));
    let values = sent.flat_map(|name| value(name).to_le_bytes()).collect();
    Sample { number: 0, clock, signals: mask, values }
}

fn watched(
    warning: Option<&'static str>,
    samples: impl IntoIterator<Item = Sample>,
) -> WatchedDevice {
    let mut watched = WatchedDevice::new(
        warning,
        "the bench, firmware 1.2.3".into(),
        Signals::of_core(),
        status(),
    );
    samples.into_iter().for_each(|sample| watched.take(&sample));
    watched
}

fn drawn(watched: &WatchedDevice, columns: u16, rows: u16) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    terminal.draw(|frame| draw(frame, watched)).unwrap();
    terminal.backend().buffer().clone()
}

fn row(buffer: &Buffer, y: u16) -> String {
    (0..buffer.area.width).map(|x| buffer[(x, y)].symbol()).collect::<String>().trim_end().into()
}

/// Returns the cells of a curve: those with braille dots of its colour.
fn curve(buffer: &Buffer, color: Color) -> Vec<(u16, u16)> {
    let all = (0..buffer.area.height).flat_map(|y| (0..buffer.area.width).map(move |x| (x, y)));
    let dotted = |symbol: &str| symbol.chars().all(|c| ('\u{2801}'..='\u{28FF}').contains(&c));
    all.filter(|at| buffer[*at].fg == color && dotted(buffer[*at].symbol())).collect()
}

#[test]
fn numbers_are_those_of_the_last_sample_in_a_users_units() {
    let watched = watched(None, [sample(4990, 7, 2), sample(4995, 200, 2)]);
    let buffer = drawn(&watched, 80, 24);
    let lines: Vec<String> = (0..24).map(|y| row(&buffer, y)).collect();
    assert_eq!(lines[0], "the bench, firmware 1.2.3, on for 50.0 s");
    assert!(lines[1].contains("ARMED") && lines[1].contains("saturated"), "{}", lines[1]);
    let words =
        |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
    assert_eq!(words(&lines[2]), "reference 5.0050 deg v_PD 2.5000 V");
    assert_eq!(words(&lines[3]), "position 2.0000 deg v_c 0.2500 V");
    assert_eq!(words(&lines[4]), "error 1.2345 deg effort v 2.7500 V");
    assert_eq!(words(&lines[5]), "velocity -6.500 deg/s applied 2.5000 V");
    assert_eq!(words(&lines[6]), "from power-on 2.0000 deg code, duty 563, -2000");
    assert_eq!(words(&lines[7]), "heat as if driven with 0.500 V for long (a model)");
    assert!(lines[23].starts_with("q quit  s stop"));
}

/// 2.5 V through 2 ohm are 1.25 A. The sensor measures 1.1 A.
#[test]
fn the_current_and_the_target_of_its_loop_are_shown_if_there_is_a_sensor() {
    let shown = |current, rows| {
        let mut watched = watched(None, []);
        watched.current = current;
        (0..=500).for_each(|i| watched.take(&sample(4000 + 2 * i, 0, 2)));
        drawn(&watched, 80, rows)
    };
    let lines =
        |buffer: &Buffer| (0..buffer.area.height).map(|y| row(buffer, y)).collect::<Vec<_>>();
    let with_loop = shown(Some(ShownCurrent { target_a_per_v: Some(0.5) }), 30);
    let words = words_of(&with_loop);
    assert!(words.contains("motor current 1.100 A, target 1.250 A heat"), "{words}");
    assert!(lines(&with_loop).iter().any(|line| line.contains("A   -- target   -- current")));
    // The target is above the current.
    let height = |color| {
        let cells = curve(&with_loop, color).into_iter().filter(|(_, y)| *y > 18);
        cells.map(|(_, y)| y).min().unwrap()
    };
    assert!(height(Color::Yellow) < height(Color::Blue));
    let sensed = shown(Some(ShownCurrent { target_a_per_v: None }), 30);
    let words = words_of(&sensed);
    assert!(words.contains("motor current 1.100 A heat") && !words.contains("target"), "{words}");
    assert!(!curve(&sensed, Color::Blue).is_empty());
    // Without the rows for a plot, the number stays; without a sensor there is none.
    assert!(words_of(&shown(Some(ShownCurrent { target_a_per_v: None }), 24)).contains("1.100 A"));
    assert!(!words_of(&shown(None, 30)).contains("current"));
}

#[test]
fn a_curve_is_where_its_values_are_and_nowhere_without_the_loop() {
    // Ten seconds: the reference at 5.005 deg, the position at 0 for the first half and at 2 deg
    // from then on.
    let samples = (0..=500).map(|i| sample(4000 + 2 * i, if i < 250 { 0 } else { 200 }, 2));
    let buffer = drawn(&watched(None, samples), 80, 24);
    // Of 14 rows of plots the upper 9 are for positions. The first has the legend, the others go
    // from 0 to 8 deg.
    assert!(row(&buffer, 9).contains("-- reference   -- position"), "{}", row(&buffer, 9));
    let row_of = |deg: f64| 10 + (31.0 * (1.0 - deg / 8.0)).round() as u16 / 4;
    let reference = curve(&buffer, Color::Yellow);
    assert!(reference.len() > 60, "{}", reference.len());
    assert!(reference.iter().all(|at| at.1 == row_of(5.005)), "{reference:?}");
    let position = curve(&buffer, Color::Cyan);
    let left = position.iter().filter(|at| at.0 < 42);
    let right = position.iter().filter(|at| at.0 > 48);
    assert!(
        left.clone().count() > 25 && left.clone().all(|at| at.1 == row_of(0.0)),
        "{position:?}"
    );
    assert!(
        right.clone().count() > 25 && right.clone().all(|at| at.1 == row_of(2.0)),
        "{position:?}"
    );
    // The effort is below: the commanded effort at the top, and the applied effort at the bottom.
    let [asked, applied] = [Color::Green, Color::Magenta].map(|color| curve(&buffer, color));
    assert!(asked.len() > 60 && asked.iter().all(|at| at.1 == 19), "{asked:?}");
    assert!(applied.len() > 60 && applied.iter().all(|at| at.1 == 20), "{applied:?}");

    // While the output is off, there is neither reference nor zero.
    let stopped = watched(None, (0..=500).map(|i| sample(4000 + 2 * i, 0, 1)));
    let buffer = drawn(&stopped, 80, 24);
    assert!(
        [Color::Yellow, Color::Cyan, Color::Green, Color::Magenta]
            .iter()
            .all(|color| curve(&buffer, *color).is_empty())
    );
    assert!(row(&buffer, 3).contains("position              - deg"), "{}", row(&buffer, 3));
}

#[test]
fn only_the_last_ten_seconds_are_kept_and_a_reset_begins_anew() {
    let mut watched = watched(None, (0..3000).map(|i| sample(i, 0, 2)));
    let times: Vec<f64> =
        watched.curves(|m: &WatchSample| m.error_deg)[0].iter().map(|point| point.0).collect();
    assert!((times[0] + 10.0).abs() < 0.02 && times[times.len() - 1] == 0.0, "{}", times[0]);
    watched.take(&sample(3, 0, 2));
    assert_eq!(watched.moments.len(), 1);
}

#[test]
fn the_warning_is_the_first_line_at_any_size() {
    let mut watched = watched(Some(SIMULATED), [sample(4995, 200, 2)]);
    watched.status.state = StateCode::Faulted(14);
    watched.status.fault = FaultReport { code: 14, tick: 320, value: 0.805 };
    (watched.lost, watched.status.wound_up, watched.status.unsaved) = (3, true, true);
    for (columns, rows) in [(80, 24), (200, 60), (44, 12), (50, 3), (42, 1)] {
        let buffer = drawn(&watched, columns, rows);
        let first = row(&buffer, 0);
        assert_eq!(first, SIMULATED[..SIMULATED.len().min(columns.into())], "{columns}x{rows}");
        assert!(
            (0..SIMULATED.len().min(columns.into()) as u16)
                .all(|x| buffer[(x, 0)].bg == Color::Red)
        );
    }
    let buffer = drawn(&watched, 200, 60);
    let state = [row(&buffer, 2), row(&buffer, 3)].join(" ");
    for part in [
        "FAULTED",
        "fault 14",
        "0.8050 V",
        "docs/reference/faults.md, \"14 Stall\"; then key c",
        "pushes a joint that does not move",
        "3 samples lost",
        "not saved",
    ] {
        assert!(state.contains(part), "{part}: {state}");
    }
}

/// A watched device with a fault, every warning and a refusal of three rows.
fn with_all_at_once() -> WatchedDevice {
    let mut watched = watched(Some(SIMULATED), [sample(4995, 200, 2)]);
    let status = &mut watched.status;
    status.state = StateCode::Faulted(14);
    status.fault = FaultReport { code: 14, tick: 320, value: 0.805 };
    (status.wound_up, status.gave_up, status.unsaved) = (true, true, true);
    (status.is_damaged, status.has_brown_out, status.crystal_not_measured) = (true, false, true);
    watched.lost = 3;
    let refused = stiction::link::RequestRefusal::TooFast;
    let why = simulator::device::words::refused(&refused);
    watched.note = format!("move: the simulated device refuses: {why} (docs/reference/link.md)");
    watched
}

fn words_of(buffer: &Buffer) -> String {
    let text = (0..buffer.area.height).map(|y| row(buffer, y) + " ").collect::<String>();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn nothing_is_cut_at_sixty_columns_with_a_fault_and_every_warning_at_once() {
    let watched = with_all_at_once();
    let words = words_of(&drawn(&watched, 60, 24));
    for part in [
        "FAULTED fault 14 (stall: effort, but no count), effort 0.8050 V, 3.200 s after power-on",
        "what to do: docs/reference/faults.md, \"14 Stall\"; then key c",
        "pushes a joint that does not move: the motor gets warm; if it lasts, key s",
        "given up: not at its target (an obstacle, or a soft gear)",
        "a saved set of parameters is damaged: see `status`",
        "crystal not measured: times are right only if it has 8 MHz",
        "brown-out reset off: `set-brown-out` turns it on",
        "parameters not saved",
        "3 samples lost",
        "saturated: no more effort",
        "heat as if driven with 0.500 V for long (a model)",
        watched.note.as_str(),
        "q quit s stop a arm",
        "move to, deg",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
}

/// A terminal with few rows still shows the fault and its remedy.
#[test]
fn what_is_dangerous_is_the_last_to_be_cut() {
    let watched = with_all_at_once();
    for (rows, parts) in [
        (18, &["3 samples lost", "move when it is slower", "q quit s stop"][..]),
        (7, &["fault 14 (stall", "then key c", "pushes a joint that does not move"]),
        (4, &["fault 14 (stall", "0.8050 V", "docs/reference/faults.md, \"14 Stall\""]),
    ] {
        let words = words_of(&drawn(&watched, 60, rows));
        assert!(words.starts_with(SIMULATED), "{words}");
        for part in parts {
            assert!(words.contains(part), "{rows} rows: {part}: {words}");
        }
    }
}

fn watched_device() -> (WatchedDevice, Client<SimulatedWire>) {
    let document = Document::open("step-response").unwrap();
    let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
    let mut client =
        Client::connect(SimulatedWire::new(SimulatedDevice::new(&plan).unwrap())).unwrap();
    let status = client.status().unwrap();
    let signals = Signals::new(client.signals().unwrap());
    (WatchedDevice::new(client.warning(), "bench".into(), signals, status), client)
}

#[test]
fn keys_arm_move_and_stop_the_device() {
    let (mut watched, mut client) = watched_device();
    let keys = |text: &str, watched: &mut WatchedDevice, client: &mut Client<SimulatedWire>| {
        let codes = text.chars().map(|c| if c == '\n' { KeyCode::Enter } else { KeyCode::Char(c) });
        codes.map(|code| press(KeyEvent::from(code), watched, client).unwrap()).last().unwrap()
    };
    let pass = |client: &mut Client<SimulatedWire>| {
        client.pass(Duration::from_secs(3)).unwrap();
        client.wire().simulated.position_deg()
    };
    // Without arming nothing moves, and the view shows the reason.
    assert_eq!(keys("2\n", &mut watched, &mut client), WatchFlow::Go);
    assert!(watched.note.contains("`arm` first"), "{}", watched.note);
    assert!(pass(&mut client).abs() < 1e-9);
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);

    keys("a", &mut watched, &mut client);
    assert!(watched.armed_here && watched.is_armed());
    // Typed, but not entered: the joint stays.
    keys("-2.5", &mut watched, &mut client);
    assert_eq!(watched.entry, "-2.5");
    assert!(pass(&mut client).abs() < 0.01);
    keys("\n", &mut watched, &mut client);
    assert!((pass(&mut client) + 2.5).abs() < 0.03);
    keys("1-2\n", &mut watched, &mut client);
    assert!(watched.note.contains("`1-2` is not a number"), "{}", watched.note);
    assert!((pass(&mut client) + 2.5).abs() < 0.03);

    // The stop key works in the middle of a number, too, and discards the number.
    keys("3s", &mut watched, &mut client);
    assert_eq!((watched.status.state, watched.entry.as_str()), (StateCode::Stopped, ""));
    assert!(!client.wire().simulated.tick().enable);
    assert_eq!(keys("q", &mut watched, &mut client), WatchFlow::Quit);
    let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(press(interrupt, &mut watched, &mut client).unwrap(), WatchFlow::Quit);
}

fn type_in(text: &str, watched: &mut WatchedDevice, client: &mut Client<SimulatedWire>) {
    for c in text.chars() {
        let code = if c == '\n' { KeyCode::Enter } else { KeyCode::Char(c) };
        assert_eq!(press(KeyEvent::from(code), watched, client).unwrap(), WatchFlow::Go);
    }
}

/// The number is shown before Enter moves, and the joint goes there.
#[test]
fn a_decimal_comma_and_an_exponent_move_to_the_number_that_is_shown_before() {
    for (typed, deg) in [("4,5", "4.5"), ("45e-1", "4.5"), ("-2,25", "-2.25"), ("+3", "3")] {
        let (mut watched, mut client) = watched_device();
        type_in("a", &mut watched, &mut client);
        type_in(typed, &mut watched, &mut client);
        for (columns, rows) in [(80, 24), (60, 24)] {
            let words = words_of(&drawn(&watched, columns, rows));
            let shown =
                format!("move to {typed}_ read as {deg} deg (Enter moves; Esc discards it)");
            assert!(words.contains(&shown), "{columns}: {words}");
        }
        type_in("\n", &mut watched, &mut client);
        assert_eq!(watched.note, format!("to {deg} deg"));
        client.pass(Duration::from_secs(3)).unwrap();
        let reached = client.wire().simulated.position_deg();
        assert!((reached - deg.parse::<f64>().unwrap()).abs() < 0.03, "{typed}: {reached}");
    }
}

/// A key that is not part of a number is not dropped inside a number.
#[test]
fn what_is_no_number_is_shown_as_typed_and_moves_nothing() {
    let (mut watched, mut client) = watched_device();
    type_in("a", &mut watched, &mut client);
    for typed in ["4x5", "4;5", "1,234", "4,5,6", "1e", "4a5", "4c5"] {
        type_in(typed, &mut watched, &mut client);
        assert_eq!(watched.entry, typed);
        let words = words_of(&drawn(&watched, 60, 24));
        assert!(words.contains(&format!("{typed}_ `{typed}` is")), "{words}");
        type_in("\n", &mut watched, &mut client);
        assert!(watched.note.contains(&format!("no move: `{typed}` is")), "{}", watched.note);
        client.pass(Duration::from_secs(1)).unwrap();
        assert!(client.wire().simulated.position_deg().abs() < 0.01, "{typed}");
        assert_eq!(client.status().unwrap().state, StateCode::Armed, "{typed}");
    }
    // An entry that is too long is discarded as a whole, and not cut to another number.
    type_in(&"1".repeat(33), &mut watched, &mut client);
    assert!(watched.entry.is_empty() && watched.note.contains("discarded"), "{}", watched.note);
}

#[test]
fn a_target_out_of_the_travel_is_refused_where_it_is_typed_with_the_range() {
    let joint = simulator::experiment::find("step-response").unwrap().toml;
    let limited = "[limits]\nposition_min_deg = -10.0\nposition_max_deg = 20.0\n";
    for (limits, typed, range) in [
        ("", "99999", "it must be -360 to 360 deg while the device has no limits of travel"),
        ("", "1e9", "it must be -360 to 360 deg while the device has no limits of travel"),
        (limited, "99999", "LIMITS from the zero of the arming"),
    ] {
        let document = Document::parse("joint.toml", &format!("{joint}\n{limits}")).unwrap();
        let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
        let mut client =
            Client::connect(SimulatedWire::new(SimulatedDevice::new(&plan).unwrap())).unwrap();
        let signals = Signals::new(client.signals().unwrap());
        let status = client.status().unwrap();
        let mask = signals.mask(subscribed());
        let mut watched = WatchedDevice::new(client.warning(), "bench".into(), signals, status);
        client.subscribe(mask, 1).unwrap();
        type_in("a", &mut watched, &mut client);
        client.pass(Duration::from_millis(100)).unwrap();
        while let Some(sample) = client.kept() {
            watched.take(&sample);
        }
        let travel = simulator::device::travel::Travel::new(&client.parameters().unwrap());
        watched.travel = Some(travel);
        watched.follow(client.status().unwrap());
        // The joint was armed where it stood at power-on, and counts are whole.
        let resolution_deg = f64::from(status.resolution);
        let end = |deg: f64| {
            let exact = (deg / resolution_deg).round() * resolution_deg;
            files::error::shown((exact * 1e4).round() / 1e4)
        };
        let limits = format!("it must be {} to {} deg", end(-10.0), end(20.0));
        let range = range.replace("LIMITS", &limits);
        type_in(typed, &mut watched, &mut client);
        let words = words_of(&drawn(&watched, 60, 24));
        assert!(words.contains(&range), "{words}");
        type_in("\n", &mut watched, &mut client);
        assert!(watched.note.contains(&range), "{}", watched.note);
        client.pass(Duration::from_secs(1)).unwrap();
        assert!(client.wire().simulated.position_deg().abs() < 0.01, "{typed}");
    }
}

/// The plotted past is in whole tens of seconds, from ten to three hundred.
#[test]
fn the_window_fits_the_move() {
    let mut watched = watched(None, [sample(4990, 7, 2)]);
    for (move_s, window_s) in [(0.5, 10.0), (10.0, 10.0), (12.3, 20.0), (4000.0, 300.0)] {
        watched.show(move_s);
        assert_eq!(watched.kept_s, window_s);
    }
    // After 12 s, the plots show what is kept.
    watched.show(12.3);
    watched.take(&sample(4990 + 1200, 7, 2));
    let buffer = drawn(&watched, 80, 24);
    assert!((0..24).any(|y| row(&buffer, y).contains("-20 s")));
    watched.take(&sample(4990 + 1900, 7, 2));
    assert_eq!(watched.moments.len(), 3);
    watched.take(&sample(4990 + 2001, 7, 2));
    assert_eq!(watched.moments.len(), 3);
}

#[test]
fn with_control_or_alt_nothing_but_stop_is_done() {
    let (mut watched, mut client) = watched_device();
    let press_all = |codes: &str,
                     modifiers,
                     watched: &mut WatchedDevice,
                     client: &mut Client<SimulatedWire>| {
        for code in codes.chars() {
            assert_eq!(
                press(KeyEvent::new(KeyCode::Char(code), modifiers), watched, client).unwrap(),
                WatchFlow::Go
            );
        }
        (watched.status.state, watched.entry.clone())
    };
    for modifiers in [KeyModifiers::CONTROL, KeyModifiers::ALT] {
        let left = press_all("ahq5-.", modifiers, &mut watched, &mut client);
        assert_eq!(left, (StateCode::Stopped, String::new()), "{modifiers:?}");
        assert_eq!(
            (watched.armed_here, client.status().unwrap().state),
            (false, StateCode::Stopped)
        );
    }
    // With Caps Lock and with a modifier that is held: stop is stop.
    for (key, modifiers) in
        [('S', KeyModifiers::SHIFT), ('s', KeyModifiers::CONTROL), (' ', KeyModifiers::ALT)]
    {
        client.pass(Duration::from_millis(200)).unwrap();
        let left = press_all("a", KeyModifiers::NONE, &mut watched, &mut client);
        assert_eq!(left.0, StateCode::Armed);
        assert_eq!(
            press_all(&key.to_string(), modifiers, &mut watched, &mut client).0,
            StateCode::Stopped,
            "{key}"
        );
    }
}

#[test]
fn a_device_that_falls_silent_while_armed_here_is_reported_as_perhaps_still_armed() {
    let (mut watched, mut client) = watched_device();
    // Refused: a joint that moves is not armed.
    client.wire().simulated.push(0.0, 20.0);
    client.pass(Duration::from_millis(40)).unwrap();
    press(KeyEvent::from(KeyCode::Char('a')), &mut watched, &mut client).unwrap();
    assert!(watched.note.contains("at rest") && !watched.armed_here, "{}", watched.note);

    let mut client = Client::connect(Cut { wire: client.end(), cut: false }).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    assert!(!super::leave(&mut client, &watched).unwrap().contains("DRIVEN"));
    client.wire().cut = true;
    assert!(press(KeyEvent::from(KeyCode::Char('a')), &mut watched, &mut client).is_err());
    // The request may have arrived.
    assert!(watched.armed_here);
    let said = super::leave(&mut client, &watched).unwrap_err().to_string();
    assert!(
        said.contains("does not answer") && said.contains("THE MOTOR MAY STILL BE DRIVEN"),
        "{said}"
    );
}

/// A wire whose return path is cut.
struct Cut {
    wire: SimulatedWire,
    cut: bool,
}

impl Wire for Cut {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.wire.send(bytes)
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        let found = self.wire.receive(at_most)?;
        Ok(if self.cut { vec![] } else { found })
    }

    fn name(&self) -> String {
        self.wire.name()
    }

    fn warning(&self) -> Option<&'static str> {
        self.wire.warning()
    }
}

#[test]
fn what_was_armed_here_is_stopped_on_leaving_and_what_was_not_is_reported() {
    let (mut watched, mut client) = watched_device();
    press(KeyEvent::from(KeyCode::Char('a')), &mut watched, &mut client).unwrap();
    assert!(super::leave(&mut client, &watched).unwrap().contains("motor is off"));
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    client.pass(Duration::from_millis(200)).unwrap();
    client.arm().unwrap();
    watched.armed_here = false;
    assert!(super::leave(&mut client, &watched).unwrap().starts_with("THE MOTOR IS STILL DRIVEN"));
    assert_eq!(client.status().unwrap().state, StateCode::Armed);
}

#[test]
fn axes_are_round_and_hold_all_values() {
    use super::view::bounds;
    let of = |values: &[f64], least| bounds(values.iter().copied(), least);
    assert_eq!(of(&[0.0, 5.005], 0.1), ([0.0, 8.0], 0));
    assert_eq!(of(&[0.0, 2.0], 0.1), ([0.0, 2.0], 1));
    assert_eq!(of(&[-0.31, 0.42], 0.1), ([-0.4, 0.8], 1));
    // Noise is not stretched: 10 counts are the least.
    let ([low, high], decimals) = of(&[1.0, 1.001], 0.0242);
    assert!(low <= 0.9884 && high >= 1.0126 && high - low < 0.05 && decimals == 3, "{low} {high}");
    for k in 1..400 {
        let (a, b) = (f64::from(k).sin() * 10f64.powi(k % 7 - 3), f64::from(3 * k).cos());
        let ([low, high], decimals) = of(&[a, b], 0.01);
        assert!(low <= a.min(b) + 1e-9 && high >= a.max(b) - 1e-9, "{a} {b}: {low} {high}");
        // The values fill at least a third of the axis, and the labels are its exact values.
        assert!(high - low <= 3.0 * (a - b).abs().max(0.01) + 1e-9, "{a} {b}: {low} {high}");
        for value in [low, 0.5 * (low + high), high] {
            let label: f64 = format!("{value:.decimals$}").parse().unwrap();
            assert!((label - value).abs() < 1e-9, "{value} as {label}");
        }
    }
}

#[test]
fn the_window_fits_a_short_move() {
    for (ticks, window_s) in [(50, 1.0), (150, 2.0), (400, 5.0), (900, 10.0), (3000, 10.0)] {
        assert_eq!(watched(None, (0..ticks).map(|i| sample(i, 0, 2))).window_s(), window_s);
    }
    assert_eq!(watched(None, (0..50).map(|i| sample(i, 0, 1))).window_s(), 10.0);
}

#[test]
fn sixty_columns_are_enough() {
    let mut watched = watched(Some(SIMULATED), [sample(4995, 200, 2)]);
    watched.status.state = StateCode::Faulted(14);
    watched.status.fault = FaultReport { code: 14, tick: 320, value: 0.805 };
    watched.note = "move: the simulated device refuses: the motor is off; `arm` first".into();
    let buffer = drawn(&watched, 60, 24);
    let text = (0..24).map(|y| row(&buffer, y) + " ").collect::<String>();
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "3.200 s after power-on",
        "code, duty 563, -2000",
        "velocity -6.500 deg/s",
        "`arm` first",
        "c clear fault",
        "move to, deg",
        "-- position",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
}
