//! Files that a command line, a scenario or a map names: anything may be there.

use rustix::fs::{CWD, FileType, Mode, OFlags, fstat, openat};
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Largest configuration or list that is written by hand. [bytes]
pub const TEXT_BYTES_MAX: u64 = 1 << 20;

/// Largest file that a run or a suite has left. [bytes]
pub const RESULT_BYTES_MAX: u64 = 256 << 20;

/// Opens the regular file `path` for reading, without waiting for the other end of a pipe or for a
/// device.
///
/// # Errors
/// `InvalidInput` when it is something else, and what the system says.
pub fn open(path: &Path) -> std::io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let file = File::from(openat(CWD, path, flags, Mode::empty())?);
    let what = match FileType::from_raw_mode(fstat(&file)?.st_mode) {
        FileType::RegularFile => return Ok(file),
        FileType::Directory => "a folder",
        FileType::Fifo => "a pipe",
        FileType::CharacterDevice | FileType::BlockDevice => "a device",
        _ => "something else",
    };
    let why = format!("is {what}, not a file");
    Err(Error::new(ErrorKind::InvalidInput, why))
}

/// The content of the regular file `path`.
///
/// # Errors
/// As [`open`], and `FileTooLarge` for more than `most` bytes.
pub fn bytes(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    bounded(open(path)?, most)
}

/// The text in the regular file `path`.
///
/// # Errors
/// As [`bytes`], and `InvalidData` for what is not UTF-8.
pub fn text(path: &Path, most: u64) -> std::io::Result<String> {
    let no_text = |_| Error::new(ErrorKind::InvalidData, "is not text in UTF-8");
    String::from_utf8(bytes(path, most)?).map_err(no_text)
}

/// All that `from` gives.
///
/// # Errors
/// `FileTooLarge` for more than `most` bytes, and what the system says.
pub fn bounded(from: impl Read, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more than allowed tells too large from just large enough.
    from.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 <= most {
        return Ok(bytes);
    }
    let why = format!("has more than {most} bytes");
    Err(Error::new(ErrorKind::FileTooLarge, why))
}

/// The end of a file that may be of any size, `most` bytes at most; what is not UTF-8 is replaced.
///
/// # Errors
/// What the system says.
pub fn tail(file: &File, most: u64) -> std::io::Result<String> {
    let mut at = file.metadata()?.len().saturating_sub(most);
    let mut bytes = Vec::new();
    let mut piece = [0; 1 << 13];
    while (bytes.len() as u64) < most {
        match file.read_at(&mut piece, at)? {
            0 => break,
            n => {
                bytes.extend_from_slice(&piece[..n]);
                at += n as u64;
            }
        }
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read_and_no_more_than_allowed() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("it");
        std::fs::write(&file, "1234").unwrap();
        assert_eq!(text(&file, 4).unwrap(), "1234");
        let error = text(&file, 3).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert_eq!(tail(&File::open(&file).unwrap(), 2).unwrap(), "34");
        let pipe = place.path().join("pipe");
        rustix::fs::mknodat(CWD, &pipe, FileType::Fifo, Mode::RWXU, 0).unwrap();
        for (path, word) in [
            (pipe.as_path(), "a pipe"),
            (Path::new("/dev/zero"), "a device"),
            (place.path(), "a folder"),
        ] {
            let error = bytes(path, 9).unwrap_err().to_string();
            assert!(error.contains(word), "{}: {error}", path.display());
        }
    }
}
