//! Routines that an image must not have: arithmetic that the processor has no instruction for.
//!
//! The Cortex-M4F computes in single precision. All other floating-point arithmetic is a call into
//! the compiler's runtime library, ten to a hundred times as slow, which the source does not show
//! at the place of the call.

use super::code::Code;

/// Names of the ARM run-time ABI (IHI 0043, tables 2 to 7) and of the compiler's library
/// (`libgcc`'s manual, 4.2), in which `s` and `d` are single and double precision.
const PREFIXES: [&str; 4] = ["__aeabi_d", "__aeabi_f", "__aeabi_cd", "__aeabi_cf"];
const CONVERSIONS: [&str; 8] = [
    "__aeabi_i2d",
    "__aeabi_ui2d",
    "__aeabi_l2d",
    "__aeabi_ul2d",
    "__aeabi_i2f",
    "__aeabi_ui2f",
    "__aeabi_h2f",
    "__aeabi_h2d",
];
const OPERATIONS: [&str; 14] =
    ["add", "sub", "mul", "div", "neg", "eq", "ne", "lt", "le", "gt", "ge", "unord", "cmp", "powi"];

/// Returns the forbidden routines that an image has.
pub fn forbidden(code: &Code) -> Vec<&str> {
    code.symbols().filter(|name| is_forbidden(name)).collect()
}

fn is_forbidden(name: &str) -> bool {
    // Rust's own library, if its public names are gone.
    let is_inner = name.contains("17compiler_builtins5float");
    if is_inner
        || PREFIXES.iter().any(|prefix| name.starts_with(prefix))
        || CONVERSIONS.contains(&name)
    {
        return true;
    }
    let Some(name) = name.strip_prefix("__") else { return false };
    // __adddf3, __ltsf2, __powidf2; __fixdfsi, __floatsidf, __extendsfdf2, __truncdfsf2
    let is_operation = OPERATIONS.iter().any(|operation| {
        let rest = name.strip_prefix(operation).unwrap_or("");
        ["sf", "df"]
            .iter()
            .any(|mode| rest.strip_prefix(mode).is_some_and(|n| matches!(n, "2" | "3")))
    });
    let is_conversion =
        ["fix", "float", "extend", "trunc"].iter().any(|verb| name.starts_with(verb))
            && ["sf", "df", "hf"].iter().any(|mode| name.contains(mode));
    is_operation || is_conversion
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn routines_of_floating_point_are_distinguished_from_those_of_integers_and_memory() {
        for name in [
            "__aeabi_dadd",
            "__aeabi_fmul",
            "__aeabi_d2f",
            "__aeabi_f2d",
            "__aeabi_dcmplt",
            "__aeabi_cfcmple",
            "__aeabi_ui2d",
            "__adddf3",
            "__mulsf3",
            "__ltdf2",
            "__fixdfsi",
            "__floatundisf",
            "__extendsfdf2",
            "__truncdfsf2",
            "__powidf2",
            "_ZN17compiler_builtins5float3add8__adddf317h0123456789abcdefE",
        ] {
            assert!(is_forbidden(name), "{name}");
        }
        for name in [
            "__aeabi_memcpy",
            "__aeabi_ldivmod",
            "__aeabi_uldivmod",
            "__divmoddi4",
            "__udivmoddi4",
            "__muldi3",
            "__ashldi3",
            "main",
            "__rust_alloc",
            "_defmt_write",
        ] {
            assert!(!is_forbidden(name), "{name}");
        }
    }
}
