//! The block on a spring (Tables 1-2): all in closed form.

use host_sim::friction::Coulomb;
use host_sim::mechanism::SpringMass;
use host_sim::solver::state::BodyEvent;
use host_sim::solver::{EventKind, located};

/// Table 1.
const BLOCK: SpringMass = SpringMass { mass: 0.1, stiffness: 100.0, speed: 0.002 };
const LEVELS: Coulomb = Coulomb { stick: 0.25, slip: 0.20 };

#[test]
fn the_staircase_is_that_of_the_closed_form() {
    let mut events: Vec<BodyEvent> = Vec::new();
    let finish = located::run(&BLOCK, &[LEVELS], 1e-8, 5.0, &mut events).unwrap();
    let breaks: Vec<f64> = events.iter().filter(|e| e.kind == EventKind::Break).map(|e| e.time_s).collect();
    let sticks: Vec<f64> = events.iter().filter(|e| e.kind == EventKind::Stick).map(|e| e.time_s).collect();
    println!("{events:?} {finish:?}");
    assert_eq!(breaks.len(), 7);
    assert!((breaks[0] - 1.25).abs() < 1e-12);
    assert!((sticks[0] - 1.35730362096765).abs() < 1e-9);
    for pair in breaks.windows(2) {
        assert!((pair[1] - pair[0] - 0.607303620967653).abs() < 1e-9);
    }
}
