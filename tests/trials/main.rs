//! The trial: what it draws, forges, runs and scores.

#[path = "../support/mod.rs"]
mod support;

mod priors;
mod trial;
mod trial_draw;
mod trial_foreign;
mod trial_runs;
mod trial_sample;
mod trial_score;
