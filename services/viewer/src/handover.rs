//! Hands the link to a browser without showing its token to others: arguments of processes can be
//! read by every user of the machine. The browser is given the name of a private file that leads
//! to the page, and the file is removed when the page has come, after a bounded time, and at the end.

use rustix::fs::OFlags;
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use zeronav_shell::folder::Folder;

/// How long a browser may take to open the page.
const LIMIT: Duration = Duration::from_secs(60);

/// A link that waits for its browser.
#[derive(Debug)]
pub(crate) struct Handover {
    file: PathBuf,
    began: Instant,
    browser: Option<Child>,
}

impl Handover {
    /// Opens `link` in the browser of the user's choice, by a file in `folder`, which nobody else
    /// can enter.
    ///
    /// # Errors
    /// What cannot be made, in one line.
    pub(crate) fn begin(folder: &Folder, link: &str) -> Result<Self, String> {
        let mut handover = Self::write(folder, link).map_err(|error| format!("--open: {error}"))?;
        let started = Command::new("xdg-open")
            .arg(&handover.file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            // The browser outlives this process and whatever ends its group.
            .process_group(0)
            .spawn();
        handover.browser = Some(started.map_err(|error| format!("xdg-open: {error}"))?);
        Ok(handover)
    }

    fn write(folder: &Folder, link: &str) -> std::io::Result<Self> {
        let name = format!("open_{}.html", std::process::id());
        let new = OFlags::CREATE | OFlags::EXCL | OFlags::WRONLY;
        let mut file = folder.file(&name, new)?;
        let handover = Self {
            file: folder.path().join(name),
            began: Instant::now(),
            browser: None,
        };
        file.write_all(page(link).as_bytes())?;
        Ok(handover)
    }

    /// True when the file is of no more use: the page is open, or it was not opened in time.
    pub(crate) fn is_over(&mut self, is_open: bool) -> bool {
        // The child's end is noted, so that it does not stay as a zombie.
        self.browser
            .take_if(|browser| !matches!(browser.try_wait(), Ok(None)));
        is_open || self.began.elapsed() > LIMIT
    }
}

impl Drop for Handover {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.file);
    }
}

/// A page that leads to `link` and tells nobody where it came from.
fn page(link: &str) -> String {
    format!(
        "<!doctype html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\">\
         <meta http-equiv=\"refresh\" content=\"0; url={link}\"><title>zeronav</title>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn the_file_is_private_and_goes_when_the_page_is_open() {
        let outer = tempfile::tempdir().expect("a folder");
        let folder = Folder::create(&outer.path().join("domain")).expect("a folder");
        let link = "http://127.0.0.1:8090/#abc";
        let mut handover = Handover::write(&folder, link).expect("a file");
        let file = handover.file.clone();
        let mode = std::fs::metadata(&file).expect("the file").mode();
        assert_eq!(mode & 0o777, 0o600);
        let text = std::fs::read_to_string(&file).expect("its text");
        assert!(text.contains(&format!("url={link}\"")), "{text}");
        assert!(
            Handover::write(&folder, link).is_err(),
            "never another's file"
        );
        assert!(!handover.is_over(false) && handover.is_over(true));
        handover.began -= LIMIT + Duration::from_secs(1);
        assert!(handover.is_over(false));
        drop(handover);
        assert!(!file.exists());
    }
}
