//! `stiction report`.

use std::path::PathBuf;

use crate::error::Error;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Where the page and its figures are written
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
}

#[cfg(not(feature = "report"))]
pub fn report(arguments: &Arguments) -> Result<(), Error> {
    let option = format!("report in {}", arguments.out.display());
    Err(crate::error::not_built(&option, "what makes it is", "report"))
}

#[cfg(feature = "report")]
pub fn report(arguments: &Arguments) -> Result<(), Error> {
    let made = crate::report::make(&arguments.out)?;
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
