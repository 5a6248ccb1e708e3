//! `stiction report`.

use std::path::PathBuf;

use super::benchmark::TuningArguments;
use files::error::Error;

#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// A machine's own TOML file, for a page on its joint [default: the page of the thesis]
    file: Option<String>,
    /// Output directory of the page, and of the thesis's figures
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    tuning: TuningArguments,
}

#[cfg(not(feature = "report"))]
pub fn report(arguments: &ReportArguments) -> Result<(), Error> {
    let ReportArguments { file: _, out, force: _, tuning: _ } = arguments;
    let option = format!("report in {}", out.display());
    Err(files::missing_part::not_built(&option, "the report is", "report"))
}

#[cfg(feature = "report")]
pub fn report(arguments: &ReportArguments) -> Result<(), Error> {
    match &arguments.file {
        Some(file) => of_a_joint(file, arguments),
        None if arguments.tuning.is_asked() => {
            Err(Error::Input("report --tuned needs a machine's file: FILE.toml".into()))
        }
        None => of_the_thesis(arguments),
    }
}

#[cfg(feature = "report")]
fn of_a_joint(file: &str, arguments: &ReportArguments) -> Result<(), Error> {
    use crate::joint_page::{JointPageRequest, make, page_name};
    use files::document::Document;
    use simulator::output::OverwriteGuard;

    let guard = OverwriteGuard::new(arguments.force).opens(file);
    let out = guard.directory("--out", &arguments.out)?;
    out.check(&page_name(file))?;
    let document = Document::open(file)?;
    if document.is_lab() {
        let why = "is a friction experiment, which has no controller";
        return Err(Error::Input(format!("{file} {why}")));
    }
    let mut documents = [document];
    let tuned = arguments.tuning.applied(&mut documents)?;
    let [document] = documents;
    let (cases, seed) = arguments.tuning.joints();
    let options = arguments.tuning.options();
    let request = JointPageRequest { document, tuned, options, cases, seed };
    let page = make(&request, &out, &super::bar::Bar::new())?;
    super::print(&format!("{}\nAll simulated: nothing has run on a motor.\n", page.display()))
}

#[cfg(feature = "report")]
fn of_the_thesis(arguments: &ReportArguments) -> Result<(), Error> {
    let guard = simulator::output::OverwriteGuard::new(arguments.force);
    let made = thesis::report::make(&guard.directory("--out", &arguments.out)?)?;
    let claims = made.claims;
    super::print(&format!(
        "{}\n{} figures beside it, as SVG and PNG. Of the thesis's claims {} hold, {} hold \
         in\npart, {} do not, {} could \
         not be measured. All simulated; made in {:.1} s.\n",
        made.page.display(),
        made.drawings,
        claims.holds,
        claims.in_part,
        claims.fails,
        claims.not_measured,
        made.wall.as_secs_f64(),
    ))
}
