//! `stiction ensemble follow`.

use std::path::PathBuf;

use super::bar::Bar;
use super::ensemble_options::cases;
use super::outputs::{check_standard_output, print_beside};
use figure::chart::Chart;
use figure::{figure_directory, write_charts};
use files::error::Error;
use files::typed_number;
use simulator::output::{OutputFile, OverwriteGuard};
use simulator::rules::rules;
use studies::ensemble::{
    Approach, Bridge, Condition, DrawOptions, Ensemble, Family, RATE_HZ, allowed_rate,
    families_under, follow, follow_charts, follow_csv, follow_json, follow_sines, follow_summaries,
    follow_table, followed_families, sine_charts, sine_json, sine_summaries, sine_table,
    slowest_table,
};

/// Set points that a joint follows.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FollowedMotion {
    /// Ramps of 1 to 1000 counts a second.
    Ramps,
    /// Sines of 0.1 to 5 Hz.
    Sines,
}

#[derive(Debug, clap::Args)]
pub struct EnsembleFollowArguments {
    /// Families of joints; all: the ten of `ensemble` except arm, which has two joints
    #[arg(long, value_name = "FAMILY", value_delimiter = ',', default_value = "all")]
    plant: Vec<String>,
    /// Number of joints of each family
    #[arg(long, default_value_t = 20, value_parser = cases())]
    cases: u64,
    /// Seed of the joints
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only these laws
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    controller: Vec<String>,
    /// Stick friction of 2 to 4 times the slip friction, instead of 1.05 to 2 times
    #[arg(long)]
    hard: bool,
    /// Set points: ramps of 1 to 1000 counts a second, or sines of 0.1 to 5 Hz
    #[arg(long, value_name = "MOTION", default_value = "ramps")]
    motion: FollowedMotion,
    /// Samples per second, Hz; thesis-axis has its own [default: 1000]
    #[arg(long, value_name = "HZ", value_parser = typed_number::parse)]
    rate: Option<f64>,
    /// Condition that no law knows, as of `ensemble`
    #[arg(long, value_name = "CONDITION", default_value = "nominal", hide_default_value = true)]
    condition: Condition,
    /// What the bridge makes of an effort, as of `ensemble`
    #[arg(long, value_name = "BRIDGE", default_value = "ideal", hide_default_value = true)]
    bridge: Bridge,
    /// One JSON object instead of tables
    #[arg(long)]
    json: bool,
    /// The table of the slowest speeds alone, in Markdown, as in docs/; of ramps
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Write a line for each joint, law and speed or frequency to this file; - for the standard
    /// output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the errors of every law into this directory, a chart for each family, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
}

impl EnsembleFollowArguments {
    pub(super) fn follow(&self) -> Result<(), Error> {
        let is_all = self.plant.iter().any(|name| name == "all");
        let fits = |family: &Family| self.condition.fits(*family) && self.bridge.fits(*family);
        let families = if is_all {
            followed_families().filter(fits).collect()
        } else {
            families_under(&self.plant, self.condition, self.bridge)?
        };
        let rate_hz = allowed_rate(self.rate.unwrap_or(RATE_HZ))?;
        let ensemble = Ensemble {
            seed: self.seed,
            cases: self.cases,
            kind: DrawOptions {
                hard: self.hard,
                rate_hz,
                condition: self.condition,
                bridge: self.bridge,
            },
            approach: Approach::default(),
            moves: 0,
            families,
            rules: rules(&self.controller)?,
        };
        let guard = OverwriteGuard::new(self.force);
        let csv = self.csv.as_ref().map(|path| guard.results("--csv", path)).transpose()?;
        check_standard_output(self.json, csv.as_ref())?;
        let plot = self.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
        let plot = plot.transpose()?;
        let (text, charts) = match self.motion {
            FollowedMotion::Ramps => self.ramps(&ensemble, csv.as_ref())?,
            FollowedMotion::Sines => self.sines(&ensemble, csv.as_ref())?,
        };
        if let Some(directory) = &plot {
            write_charts(directory, &charts)?;
        }
        print_beside(csv.as_ref(), &text)
    }

    fn ramps(
        &self,
        ensemble: &Ensemble,
        csv: Option<&OutputFile>,
    ) -> Result<(String, Vec<Chart>), Error> {
        let rows = follow(ensemble, &Bar::new())?;
        if let Some(file) = csv {
            file.write(&follow_csv(&rows)?)?;
        }
        let summaries = follow_summaries(&rows);
        let text = match (self.json, self.markdown) {
            (true, _) => format!("{:#}\n", follow_json(ensemble, &summaries)),
            (_, true) => slowest_table(&summaries, true),
            _ => follow_table(ensemble, &summaries),
        };
        Ok((text, follow_charts(&summaries)))
    }

    fn sines(
        &self,
        ensemble: &Ensemble,
        csv: Option<&OutputFile>,
    ) -> Result<(String, Vec<Chart>), Error> {
        if self.markdown {
            return Err(Error::Input("--markdown goes with --motion ramps only".into()));
        }
        let rows = follow_sines(ensemble, &Bar::new())?;
        if let Some(file) = csv {
            file.write(&follow_csv(&rows)?)?;
        }
        let summaries = sine_summaries(&rows);
        let text = if self.json {
            format!("{:#}\n", sine_json(ensemble, &summaries))
        } else {
            sine_table(ensemble, &summaries)
        };
        Ok((text, sine_charts(&summaries)))
    }
}
