//! `cargo xtask gates` checks what the firmware must not contain. The simulator's program
//! `stiction-cost` checks each image. Here the linker proves that the control path has no panic.

use std::fs;

use crate::cost;
use crate::firmware::{self, PROFILE};
use crate::job::{Job, cargo};
use crate::toolchain::{LIBRARY_TARGETS, MICROCONTROLLER, TARGET, Toolchain};

/// A program that must link. That shows that its code cannot panic: its panic handler calls a
/// function that is not defined.
struct LinkProof {
    /// Its package.
    program: &'static str,
    /// Its features, with commas between.
    features: &'static str,
    /// Announcement of the link.
    links: &'static str,
    /// The function that is not defined.
    missing: &'static str,
    /// Functions that the linker must not drop, as both of Rust's manglings spell them.
    kept: &'static [&'static [u8]],
    /// Faults that must stop the linker: the feature that plants one, what it is, and what the
    /// linker then says. A gate that never fails would prove nothing.
    planted: &'static [(&'static str, &'static str, &'static str)],
}

/// The core's tick, the link's parser and the fits of an identification: `servo::control`,
/// `link::request::numbered` and `link::session::go_on`.
const CONTROL_PATH: LinkProof = LinkProof {
    program: "no-panic",
    features: "",
    links: "Linking the control path without a panic handler",
    missing: "the_control_path_can_panic",
    kept: &[
        b"8stiction5servo7control",
        b"8stiction4link7request8numbered",
        b"8stiction4link7session5go_on",
    ],
    planted: &[("deliberate-panic", "a panic in the control path", "the_control_path_can_panic")],
};

/// The same with the law for two encoders, `control::laws::robust_dual`.
const CONTROL_PATH_TWO_ENCODERS: LinkProof = LinkProof {
    features: "two-encoders",
    links: "Linking the control path for two encoders without a panic handler",
    kept: &[b"8stiction5servo7control", b"8stiction7control4laws11robust_dual"],
    ..CONTROL_PATH
};

/// The library in the program of another board: `control::laws::robust`.
const OTHER_FIRMWARE: LinkProof = LinkProof {
    program: "other-firmware",
    features: "monitors,pd,path",
    links: "Linking the library into the program of another board",
    missing: "the_positioner_can_panic",
    kept: &[b"8stiction7control4laws6robust"],
    planted: &[
        ("deliberate-panic", "a panic beside the library", "the_positioner_can_panic"),
        ("deliberate-clash", "the firmware's board beside another one", "vectors are missing"),
    ],
};

/// What of the library is in the program of another board, its feature there, and the largest
/// flash that it may take, bytes. Measured: 11 964, 22 948, 2 516 and
/// 4 968.
const SIZES: [(&str, &str, usize); 4] = [
    ("robust", "robust", 12_288),
    ("robust with monitors", "monitors", 23_552),
    ("PD with smooth robust nonlinear feedback", "pd", 2_560),
    ("the profile of a move, and a counter", "path", 5_120),
];

/// Runs every gate.
pub fn pass(features: [&str; 3]) -> Result<(), String> {
    let images = firmware::build_all()?;
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    for proof in [&CONTROL_PATH, &CONTROL_PATH_TWO_ENCODERS, &OTHER_FIRMWARE] {
        proof.pass(&toolchain)?;
    }
    sizes(&toolchain)?;
    other_cores()?;
    Job::new("The package of the library, unpacked and compiled").run(&mut cargo(&[
        "package",
        "--quiet",
        "--package",
        "stiction",
        "--no-default-features",
        "--allow-dirty",
    ]))?;
    images.into_iter().try_for_each(|image| {
        let arguments = ["gates".into(), "--image".into(), image.into()];
        cost::run("Looking through an image", features, &arguments)
    })
}

/// Measures the flash that the library takes in the program of another board: what the program
/// grows by.
fn sizes(toolchain: &Toolchain) -> Result<(), String> {
    let job = Job::new("Flash of the library in the program of another board");
    job.announce();
    let of = |features: &str| -> Result<usize, String> {
        let mut build = toolchain.cargo(&OTHER_FIRMWARE.arguments(features));
        job.run_silently(&mut build)?;
        Ok(crate::elf::flash_contents(&OTHER_FIRMWARE.image()?)?.len())
    };
    let empty = of("")?;
    for (what, feature, most) in SIZES {
        let size = of(feature)? - empty;
        println!("{size:>6} of {most} bytes: {what}");
        if size > most {
            return Err(format!("{what} takes {size} bytes of flash; the limit is {most}"));
        }
    }
    Ok(())
}

/// Builds the library, with and without a device around the laws, for the cores of other boards.
fn other_cores() -> Result<(), String> {
    let job = Job::new("Building the library for Cortex-M0, Cortex-M33 and RISC-V");
    job.announce();
    for target in &LIBRARY_TARGETS {
        let toolchain = Toolchain::ready(target)?;
        for more in [&["--no-default-features"][..], &[]] {
            let library = ["build", "--package", "stiction", "--lib", "--target", target.name];
            let mut build = toolchain.cargo(&[&library, more].concat());
            job.run_silently(&mut build).map_err(|why| format!("{why} for {}", target.name))?;
        }
    }
    Ok(())
}

impl LinkProof {
    /// Returns the arguments of cargo that link the program.
    fn arguments<'a>(&self, features: &'a str) -> [&'a str; 9] {
        let [profile, package, target] = ["--profile", "--package", "--target"];
        let program = self.program;
        ["build", profile, PROFILE, package, program, target, TARGET, "--features", features]
    }

    /// Returns the linked program.
    fn image(&self) -> Result<Vec<u8>, String> {
        let built = firmware::built(self.program);
        fs::read(&built).map_err(|error| format!("cannot read {}: {error}", built.display()))
    }

    /// Links the program, and then with each planted fault, which must fail.
    fn pass(&self, toolchain: &Toolchain) -> Result<(), String> {
        let Self { program, features, links, missing, kept, planted } = self;
        let link = |features: &str| toolchain.cargo(&self.arguments(features));
        Job::new(links).run(&mut link(features)).map_err(|why| {
            format!("{why}: if the linker misses `{missing}`, something in {program} can panic")
        })?;
        let image = self.image()?;
        if !kept.iter().all(|name| image.windows(name.len()).any(|window| window == *name)) {
            return Err(format!(
                "{program}: the linker has dropped what is to be proved, so this shows nothing"
            ));
        }
        for (feature, what, expected) in *planted {
            println!("== Linking it with {what}, which must fail");
            let output = link(&format!("{features},{feature}")).output();
            let output = output.map_err(|error| format!("cannot start cargo: {error}"))?;
            let said = String::from_utf8_lossy(&output.stderr);
            if output.status.success() || !said.contains(expected) {
                return Err(format!("{what} does not stop the linker:\n{said}"));
            }
        }
        Ok(())
    }
}
