//! Files that appear whole or not at all, and their names.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

use crate::{Error, Result};

/// Writes the bytes beside `path` and renames them there.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let dir = path.parent().unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".clerestory-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any other new file: the umask takes what it wants.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let io = |e: std::io::Error| Error::io(path, &e);
    let mut file = builder.tempfile_in(dir).map_err(io)?;
    file.write_all(bytes).map_err(io)?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// Longest stem in characters.
const LONGEST: usize = 80;

/// File names made of the users' names, each given once, also where upper and lower case are the same.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    /// A stem for `name` that is free with all the endings.
    pub(super) fn claim(&mut self, name: &str, endings: &[&str]) -> String {
        let safe = safe(name);
        let mut stem = safe.clone();
        let mut count = 1;
        while endings.iter().any(|e| self.0.contains(&key(&stem, e))) {
            count += 1;
            stem = format!("{safe}-{count}");
        }
        self.0.extend(endings.iter().map(|e| key(&stem, e)));
        stem
    }
}

fn key(stem: &str, ending: &str) -> String {
    format!("{stem}{ending}").to_lowercase()
}

/// Letters, digits, `-`, `_` and inner dots stay; anything else becomes `_`.
fn safe(name: &str) -> String {
    let kept: String = name
        .chars()
        .take(LONGEST)
        .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' })
        .collect();
    let trimmed = kept.trim_matches('.');
    if trimmed.is_empty() { "unnamed".into() } else { trimmed.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_directory_and_differ() {
        let mut names = Names::default();
        assert_eq!(names.claim("work plane/../x", &[""]), "work_plane_.._x");
        assert_eq!(names.claim("Büro", &[""]), "Büro");
        assert_eq!(names.claim("..", &[""]), "unnamed");
        assert_eq!(names.claim("a_luminance", &[""]), "a_luminance");
        assert_eq!(names.claim("A", &["", "_luminance"]), "A-2");
        assert_eq!(names.claim("b", &["", "_luminance"]), "b");
        assert_eq!(names.claim("B", &[""]), "B-2");
    }

    #[test]
    fn a_file_replaces_the_old_one_and_leaves_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_whole(&path, b"old").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(mode & 0o600, 0o600);
            assert_eq!(mode & 0o111, 0);
        }
    }

    #[test]
    fn a_place_that_cannot_be_written_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("none").join("a.txt");
        let said = write_whole(&path, b"x").unwrap_err().to_string();
        assert!(said.starts_with(&path.display().to_string()), "{said}");
    }
}
