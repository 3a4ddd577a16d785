//! Where the sources of zeronav are that a package is built with.

use std::path::{Path, PathBuf};
use zeronav_console::version::VERSION;

/// Files that sources of zeronav have.
const MARKS: [&str; 3] = [
    "services/shell/Cargo.toml",
    "services/python/pyproject.toml",
    "services/cpp/zeronav_service.hpp",
];

/// Sources of zeronav.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sources {
    /// A folder, by its absolute path.
    Folder(PathBuf),
    /// A git repository: its address, and the commit of this program when it is known.
    Git { url: String, commit: Option<String> },
}

impl Sources {
    /// Those that the command line names, or those that this program was built from.
    ///
    /// # Errors
    /// They are not there, or are something else.
    pub(crate) fn find(named: Option<&str>) -> Result<Self, String> {
        let Some(named) = named else {
            let own = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
            let own = own.unwrap_or_else(|| Path::new("/"));
            return Self::folder(own).map_err(|why| {
                format!(
                    "the sources that this zeronav was built from are gone ({why}): --zeronav names a \
                     checkout of zeronav {VERSION}, or the address of its git repository"
                )
            });
        };
        if named.contains("://") {
            if named.contains(['"', '\'', '\\'])
                || named
                    .chars()
                    .any(|it| it.is_whitespace() || it.is_control())
            {
                return Err(format!("--zeronav {named}: no address of a repository"));
            }
            let commit = VERSION
                .split_once("(commit ")
                .and_then(|(_, rest)| rest.strip_suffix(')'));
            let (url, commit) = (named.to_owned(), commit.map(str::to_owned));
            return Ok(Self::Git { url, commit });
        }
        Self::folder(Path::new(named)).map_err(|why| format!("--zeronav {named}: {why}"))
    }

    fn folder(folder: &Path) -> Result<Self, String> {
        let absolute = folder
            .canonicalize()
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        if absolute
            .to_str()
            .is_none_or(|path| path.chars().any(char::is_control))
        {
            return Err("the name of the folder is no plain text".to_owned());
        }
        match MARKS.iter().find(|mark| !absolute.join(mark).is_file()) {
            Some(mark) => Err(format!(
                "no sources of zeronav: there is no {}",
                absolute.join(mark).display()
            )),
            None => Ok(Self::Folder(absolute)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_a_folder_or_an_address() {
        let own = Sources::find(None).unwrap();
        let Sources::Folder(folder) = &own else {
            panic!("{own:?}")
        };
        assert_eq!(Sources::find(folder.to_str()), Ok(own.clone()));
        let other = tempfile::tempdir().unwrap();
        let why = Sources::find(other.path().to_str()).unwrap_err();
        assert!(why.contains("services/shell/Cargo.toml"), "{why}");
        let git = Sources::find(Some("https://example.org/zeronav.git")).unwrap();
        assert!(
            matches!(git, Sources::Git { url, .. } if url == "https://example.org/zeronav.git")
        );
        assert!(Sources::find(Some("https://example.org/x\" }")).is_err());
    }
}
