//! Refusals in the words of a page, which has no options.

use crate::error::Error;

/// The same refusal without the options of a command line. What is no fault of the link is a
/// refusal: the session with the device goes on.
pub fn of_a_page(error: Error) -> Error {
    match error {
        Error::Input(text) => Error::Input(said(&text)),
        Error::Refused(text) => Error::Refused(said(&text)),
        Error::Device(text) if text.starts_with("selftest") => Error::Refused(said(&text)),
        other => other,
    }
}

/// The page has fields for a range and for limits. It sets keys by its own names.
fn said(text: &str) -> String {
    text.replace("--set ", "").replace("--range ", "range ").replace("--limit ", "limit ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_of_a_command_is_told_without_its_options_and_the_link_s_is_left_alone() {
        let told = |error| of_a_page(error).to_string();
        assert_eq!(told(Error::Input("--limit a=1: no".into())), "limit a=1: no");
        assert_eq!(told(Error::Refused("give --range 3 a try".into())), "give range 3 a try");
        let of_test = of_a_page(Error::Device("selftest: a smaller --range may help".into()));
        assert!(matches!(of_test, Error::Refused(_)) && !of_test.to_string().contains("--"));
        assert!(matches!(of_a_page(Error::Device("it is gone".into())), Error::Device(_)));
    }
}
