//! `slideway trial forge`: machines with hidden effects.

use std::io::{self, Write as _};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::trial::forge::{Progress, forge};
use slideway::trial::{self, Engine, Order, Seed, Tier};

use super::all_cores;
use crate::cli::count::{count, jobs};
use crate::cli::{Failure, Screen};

/// Draws what is hidden in each case, seals it, prints its SHA-256, and only then simulates the recordings. Effects are
/// drawn as machines have them, each from the prior that its law states; nothing is drawn again because it does not show.
/// Half of the twins state the friction of the guide, all dry friction has a bristle, a third of the machines have a small
/// cogging force and a small offset besides. Runs are as users record them: acceptance strokes, one run, three runs, jogs,
/// sines, multisines, production. The forging plant is not the diagnosing one: another engine at an eighth of its step,
/// made finer until the run has converged, harmonics that the catalogue lacks, other modal masses, nominal parameters a
/// little off. Tiers: null (nothing hidden), single, pair, triple, outside (the effect is struck from the catalogue, or no
/// law describes it: shocks, missed samples, a drifting clock, a warming scale), poor (nominal parameters off together),
/// missing (no current, effort or velocity), change (one machine before and after).
#[derive(Debug, Args)]
#[command(
    after_help = "Seeds below 1000 are for development: their trials may be looked at while the diagnosis is being \
                        changed.\nSeeds from 1000000 on are for judging: once."
)]
pub(super) struct Forge {
    /// Machine folder, or a machine file; it needs a [controller]
    #[arg(long, value_name = "DIR|FILE")]
    machine: PathBuf,
    /// Seed: below 1000 for development, from 1000000 on for judging
    #[arg(long, value_parser = seed)]
    seed: Seed,
    /// Tiers to forge [default: all]
    #[arg(long = "tier", value_name = "TIER", num_args = 1.., value_parser = tier())]
    tiers: Vec<Tier>,
    /// Cases of each tier [default: null 300, single 5 of each effect, pair and triple 40, the others 1 of each effect]
    #[arg(long, value_name = "N", value_parser = count)]
    cases: Option<NonZeroUsize>,
    /// Engine to simulate on; mujoco needs a build with that feature
    #[arg(long, visible_alias = "plant", default_value_t = Engine::Rapier, value_parser = engine())]
    engine: Engine,
    /// Cores to work on [default: all]
    #[arg(long, value_name = "N", value_parser = jobs)]
    jobs: Option<NonZeroUsize>,
    /// Folder to write the trial to; a trial that was left unfinished goes on
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

fn seed(text: &str) -> Result<Seed, String> {
    let number: u64 = text.parse().map_err(|_| "not a whole number".to_owned())?;
    Seed::new(number).map_err(|error| error.to_string())
}

fn tier() -> impl clap::builder::TypedValueParser<Value = Tier> {
    PossibleValuesParser::new(Tier::ALL.map(Tier::name)).try_map(|name| name.parse::<Tier>())
}

fn engine() -> impl clap::builder::TypedValueParser<Value = Engine> {
    PossibleValuesParser::new(Engine::ALL.map(Engine::name)).try_map(|name| name.parse::<Engine>())
}

impl Forge {
    /// Forges, and tells the hash before anything is simulated.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let machine = Machine::read(&self.machine)?;
        let mut tiers = if self.tiers.is_empty() { Tier::ALL.to_vec() } else { self.tiers.clone() };
        tiers.sort_unstable();
        tiers.dedup();
        let order = Order {
            machine: &machine,
            seed: self.seed,
            tiers: &tiers,
            cases: self.cases.map(NonZeroUsize::get),
            engine: self.engine,
            folder: &self.out,
        };
        let bar = screen.progress(0, "drawing");
        let drawing = |cases: usize| bar.set_length(2 * cases as u64);
        let sealed = |trial: &trial::Trial| {
            bar.set_message("simulating");
            bar.suspend(|| {
                if !screen.quiet {
                    announce(trial);
                }
            });
        };
        let done = || bar.inc(1);
        let progress = Progress { drawing: &drawing, sealed: &sealed, done: &done };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs.unwrap_or_else(all_cores).get());
        let pool = pool.build().map_err(|error| {
            Error::new(ErrorKind::OutOfRange)
                .key("--jobs")
                .found(error.to_string())
                .expected("threads to work on")
                .remedy("ask for fewer")
        })?;
        let trial = pool.install(|| forge(&order, &progress));
        bar.finish_and_clear();
        let trial = trial?;
        writeln!(
            screen.out,
            "{} cases forged; next: slideway trial run {}",
            trial.announcement.cases,
            self.out.display()
        )?;
        Ok(ExitCode::SUCCESS)
    }
}

/// What must be known before anything is diagnosed, told at once and not at the end.
fn announce(trial: &trial::Trial) {
    let announcement = &trial.announcement;
    let mut out = io::stdout().lock();
    let tiers: Vec<&str> = announcement.tiers.iter().map(|tier| tier.name()).collect();
    let mut text = format!(
        "truth sealed, SHA-256 {}\nseed {}; {} cases of the tiers {}; forged on {}\n",
        announcement.truth_sha256,
        trial.seed,
        announcement.cases,
        tiers.join(", "),
        announcement.engine,
    );
    for skipped in &announcement.skipped {
        text += &format!("not forged: {}: {}\n", skipped.effect.name(), skipped.reason);
    }
    // Where nobody listens, trial.toml has it all.
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}
