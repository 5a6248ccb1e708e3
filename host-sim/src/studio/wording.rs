//! Refusals in the terms of a page, which has no command-line options.

use files::error::Error;

/// Removes the command-line options from a refusal. An error that is not the link's becomes a
/// refusal, since the session with the device goes on.
pub fn of_a_page(error: Error) -> Error {
    match error {
        Error::Input(text) => Error::Input(said(&text)),
        Error::Refused(text) => Error::Refused(said(&text)),
        Error::Device(text) if text.starts_with("selftest") => Error::Refused(said(&text)),
        other => other,
    }
}

/// Replaces options by the page's fields of the same meaning.
fn said(text: &str) -> String {
    text.replace("--set ", "")
        .replace("--range ", "range ")
        .replace("--limit ", "limit ")
        .replace("--speed ", "a speed of ")
}

/// Explains why an identification has found no joint for a file. Where the command suggests an
/// option, the page names the parameters that set the bounds.
pub fn without_bounds(why: &str) -> String {
    match why.split_once(": ") {
        Some((cause, advice)) if advice.contains("--") => format!(
            "{cause}; identify again. The bounds are the device's: the effort is that of \
             limits.breakaway_v, the speed that of profile.velocity_deg_per_s"
        ),
        _ => why.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use stiction::identification::{Doubts, Outcome};

    use super::*;
    use simulator::device::identified::{doubts, ended};

    #[test]
    fn why_an_identification_has_found_no_joint_is_explained_without_the_command_s_options() {
        let all = Doubts {
            no_fit: true,
            poor_fit: true,
            few_rows: true,
            uneven: true,
            lost_motion: true,
            unphysical: true,
        };
        let outcomes = [
            Outcome::Running,
            Outcome::Done,
            Outcome::Reversed,
            Outcome::Pulled,
            Outcome::Still,
            Outcome::RunsOn,
            Outcome::Travel,
            Outcome::Speed,
            Outcome::Time,
            Outcome::Capped,
        ];
        let of_command = outcomes.map(ended).into_iter().chain(doubts(&all));
        let (mut mapped, mut kept) = (0, 0);
        for why in of_command {
            let shown = without_bounds(why);
            assert!(!shown.contains("--"), "{shown}");
            // The cause is unchanged.
            assert!(shown.starts_with(why.split(':').next().unwrap_or(why)), "{shown}");
            mapped += u32::from(shown.contains("identify again. The bounds are the device's"));
            kept += u32::from(shown == why);
        }
        // Still, Travel, Speed, Time and few rows.
        assert_eq!((mapped, kept), (5, 11));
    }

    #[test]
    fn a_refusal_of_a_command_has_no_options_and_the_link_s_error_is_left_alone() {
        let shown = |error| of_a_page(error).to_string();
        assert_eq!(shown(Error::Input("--limit a=1: no".into())), "limit a=1: no");
        assert_eq!(shown(Error::Refused("give --range 3 a try".into())), "give range 3 a try");
        let refused = Error::Refused("use --speed 0.12 or more".into());
        assert_eq!(shown(refused), "use a speed of 0.12 or more");
        let of_test = of_a_page(Error::Device("selftest: a smaller --range may help".into()));
        assert!(matches!(of_test, Error::Refused(_)) && !of_test.to_string().contains("--"));
        assert!(matches!(of_a_page(Error::Device("it is gone".into())), Error::Device(_)));
    }
}
