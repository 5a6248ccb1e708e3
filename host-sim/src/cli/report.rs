//! `stiction report`.

use std::path::PathBuf;

use super::print;
use crate::error::Error;
use crate::report;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Where the page and its figures are written
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
}

pub fn report(arguments: &Arguments) -> Result<(), Error> {
    let made = report::make(&arguments.out)?;
    let claims = made.claims;
    print(&format!(
        "{}\n{} figures beside it, as SVG and PNG. Of the thesis's claims {} hold, {} hold in\npart, {} do not, {} could \
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
