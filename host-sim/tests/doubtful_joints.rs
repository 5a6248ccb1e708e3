//! What a file says of a doubtful joint: the truth is within its `[spread]`. The joints are drawn,
//! so that their truth is known, and identified by the core's own sequence.
#![allow(missing_docs, clippy::unwrap_used)]

use dynamics::joint::{Ripple, Train};
use simulator::device;
use simulator::experiment::{Document, Experiment, parameters};
use stiction::identification::IdentificationRequest;
use studies::ensemble::{TrueJoint, UNEVEN, drawn, identify};

const KEYS: [&str; 4] = [
    "joint.gain_deg_per_s2_per_v",
    "joint.viscous_v_per_deg_per_s",
    "joint.friction.slip_v",
    "joint.friction.stick_v",
];

/// Returns the number of doubtful joints whose gain, viscous friction, slip and stick are within
/// their spread, and the number of doubtful joints.
fn held(name: &str, cases: u64) -> ([usize; 4], usize) {
    // Of the device only the step of its drive is asked for, and that for a line of text.
    let document = Document::open("step-response").unwrap();
    let plan = Experiment::without_variants(&document, &["pd".into()]).unwrap().remove(0);
    let parameters = parameters(&plan).unwrap();
    let (mut held, mut doubtful) = ([0; 4], 0);
    for number in 0..cases {
        let mut case = drawn(name, 3, number).unwrap();
        // With levels that vary by twice as much most fits are poor, and no file is written.
        if let (UNEVEN, Train::Rigid(body)) = (name, &mut case.joint.train) {
            body.friction.ripple =
                body.friction.ripple.map(|of| Ripple { depth: 0.5 * of.depth, ..of });
        }
        let found = identify(&case, &IdentificationRequest::default()).unwrap();
        let Some(summary) = found.summary else { continue };
        let found_by_device = device::identified::IdentifiedJoint {
            summary,
            map: found.map,
            parameters: parameters.clone(),
            units: None,
            gear: None,
        };
        if found_by_device.verdict() != "doubtful" {
            continue;
        }
        let Ok(joint) = found_by_device.joint() else { continue };
        doubtful += 1;
        let TrueJoint { inertia, viscous, slip, stick, .. } = found.truth;
        let truths = [1.0 / inertia, viscous, slip, stick];
        let spread = device::spread::spread(&found_by_device, &joint);
        let ranges = KEYS.map(|key| spread[key]);
        let shown: Vec<String> = ranges
            .iter()
            .zip(truths)
            .map(|([low, high], truth)| format!("{:.2}..{:.2}", low / truth, high / truth))
            .collect();
        println!(
            "{name} {number}: {shown:?} {:.2} {:.2} {:.2} {:?}",
            stick / joint.friction.stick_v,
            inertia * joint.gain_deg_per_s2_per_v,
            joint.friction.stick_v / joint.friction.slip_v,
            found_by_device.summary.doubts,
        );
        for ((count, [low, high]), truth) in held.iter_mut().zip(ranges).zip(truths) {
            *count += usize::from((low..=high).contains(&truth));
        }
    }
    println!("{name}: {held:?} of {doubtful}");
    (held, doubtful)
}

/// Error bars of a model that does not hold do not hold the truth: of the breakaway of `lugre` and
/// `flexible-backlash` they held 16 and 19 % (docs/how-to/identify.md).
#[test]
fn a_doubtful_joint_is_within_what_its_file_says_that_it_may_be_off() {
    for (name, cases) in
        [(UNEVEN, 40), ("lugre", 40), ("flexible-motor", 40), ("flexible-backlash", 40)]
    {
        let (held, doubtful) = held(name, cases);
        assert!(doubtful >= 6, "{name}: {doubtful}");
        // A doubt is no error bar: what is asked for is that most joints are within.
        assert!(held.iter().all(|held| 5 * held >= 4 * doubtful), "{name}: {held:?} of {doubtful}");
    }
}
