//! The command line, the reports, the shipped machines and the project itself.

#[path = "../support/mod.rs"]
mod support;

mod architecture;
mod catalogue;
mod ci;
mod cli;
mod compared;
mod diagnose_cli;
mod html;
mod imports;
mod init;
mod known;
mod machines;
mod report;
mod screenshots;
