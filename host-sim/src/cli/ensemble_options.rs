//! Options that the commands of `stiction ensemble` share.

use clap::builder::TypedValueParser;

use studies::ensemble::CASES_ALLOWED;

/// Returns the parser of the number of joints of a family.
pub(super) fn cases() -> impl TypedValueParser<Value = u64> {
    clap::value_parser!(u64).range(CASES_ALLOWED)
}
