//! Blind trials: the diagnosis checked on machines whose effect is withheld.
//!
//! A trial has three steps, each a command, and what passes between them lies in one folder:
//!
//! ```text
//! forge   draws machines with hidden effects, seals the truth, prints its hash, simulates their recordings
//! run     diagnoses the recordings and commits the verdicts; it cannot open the seal
//! score   opens the seal against committed verdicts, and compares
//!
//! TRIAL/trial.toml                what was forged: seed, tiers, machine, engine, SHA-256 of the truth
//! TRIAL/sealed/truth.json         the truth
//! TRIAL/sealed/opened.json        once opened: the hash of the verdicts that it was opened against
//! TRIAL/cases/NNN/                a recording, as any other
//! TRIAL/cases/NNN.before/         in the tier of changes, the recording of the same machine before
//! TRIAL/cases/NNN.case.toml       effects struck from the catalogue for this case, and what its twin states beyond the machine's file
//! TRIAL/verdicts/NNN.json         a verdict, schema slideway-diagnosis/1
//! TRIAL/verdicts/committed.json   SHA-256 and computing time of every verdict
//! ```
//!
//! # Design
//! - **The seal is a type.** [`Sealed`] holds a path and a hash, and opens only for [`CommittedVerdicts`], which only
//!   [`CommittedVerdicts::read`] makes, from a folder in which every case has its verdict and every hash is right.
//!   Once open, no verdict may change: [`run()`] refuses to commit any more.
//! - **The forging plant is not the diagnosing one**: see [`engine`] and [`laws`].
//! - **A trial draws what machines have.** Every law has a prior with its source ([`EffectId::draw`](crate::effect::EffectId::draw)). Nothing is
//!   drawn again because it does not show; what each hidden effect makes is measured ([`gauge`]) and stands in the truth.
//! - **What nobody could know is told apart by the truth itself**, from its Fisher information; see [`information`].
//! - **Runs are as users record them**: see [`runs`].
//! - **The forged run has converged**: see [`convergence`].
//! - **Judging is apart from developing** by the seed: see [`Seed`].
//! - **Everything follows from the seed**: forging again, after a kill or elsewhere, gives the same bytes.

pub mod bristle;
pub mod convergence;
pub mod draw;
pub mod engine;
pub mod equals;
pub mod folder;
pub mod foreign;
pub mod forge;
pub mod gauge;
pub mod hide;
pub mod information;
pub mod laws;
pub mod nominal;
pub mod nuisance;
pub mod plan;
pub mod real;
pub mod run;
pub mod runs;
pub mod scale;
pub mod scoring;
pub mod seal;
pub mod seed;
pub mod tier;
pub mod truth;
pub mod verdict;

pub use engine::Engine;
pub use folder::Trial;
pub use forge::{Order, forge};
pub use run::run;
pub use scoring::{Scores, score};
pub use seal::{CommittedVerdicts, Sealed};
pub use seed::Seed;
pub use tier::Tier;
pub use truth::Truth;
