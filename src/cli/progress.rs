//! Progress on standard error: a bar on a terminal, a line per stage elsewhere.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};

use crate::measure::{Progress, Silent};

/// The progress that suits the place where standard error goes.
pub(super) fn progress(quiet: bool) -> Box<dyn Progress> {
    if quiet {
        Box::new(Silent)
    } else if io::stderr().is_terminal() {
        Box::new(Bar(Mutex::new(ProgressBar::hidden())))
    } else {
        Box::new(Lines)
    }
}

/// A bar that is redrawn.
#[derive(Debug)]
struct Bar(Mutex<ProgressBar>);

impl Bar {
    fn bar(&self) -> ProgressBar {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Progress for Bar {
    fn stage(&self, name: &str, total: u64) {
        let template = if total == 0 { "{msg:<24} {elapsed}" } else { "{msg:<24} {wide_bar} {percent:>3} % {eta}" };
        let bar = if total == 0 { ProgressBar::no_length() } else { ProgressBar::new(total) };
        // The templates are constants; a wrong one would only cost the looks.
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(name.to_owned());
        let mut current = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        current.finish_and_clear();
        *current = bar;
    }

    fn advance(&self, n: u64) {
        self.bar().inc(n);
    }

    fn note(&self, text: &str) {
        self.bar().suspend(|| line(text));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar().finish_and_clear();
    }
}

/// A line per stage.
#[derive(Debug)]
struct Lines;

impl Progress for Lines {
    fn stage(&self, name: &str, _: u64) {
        line(name);
    }

    fn advance(&self, _: u64) {}

    fn note(&self, text: &str) {
        line(text);
    }
}

/// A line on standard error, which may be closed.
pub(super) fn line(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}
