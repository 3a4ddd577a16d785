//! Files that a command leaves: each is whole or not there.

use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Writes `text` to a file beside `file`, makes it durable and gives it the name `file`.
///
/// # Errors
/// One line naming the file; what was there before is still there.
pub(crate) fn write(file: &Path, text: &str) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("writing {}: {error}", file.display());
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let part = file.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let written = write_whole(&part, text.as_bytes())
        .and_then(|()| std::fs::rename(&part, file))
        .and_then(|()| sync_folder(file));
    written.map_err(|error| {
        // Half a file is of no use; without it there is more room.
        let _ = std::fs::remove_file(&part);
        failed(error)
    })
}

fn write_whole(file: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut open = File::create(file)?;
    open.write_all(bytes)?;
    open.sync_all()
}

/// Makes the name of `file` durable, too.
fn sync_folder(file: &Path) -> std::io::Result<()> {
    match file.parent().filter(|folder| *folder != Path::new("")) {
        Some(folder) => File::open(folder)?.sync_all(),
        None => File::open(".")?.sync_all(),
    }
}

#[cfg(test)]
mod tests {
    use super::write;

    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("result.json");
        write(&file, "first").expect("written");
        write(&file, "second").expect("written over");
        assert_eq!(std::fs::read_to_string(&file).expect("read"), "second");
        // A folder in the way of the name: nothing is left beside it.
        let taken = folder.path().join("taken");
        std::fs::create_dir_all(taken.join("in_use")).expect("a folder");
        let problem = write(&taken, "text").expect_err("the name is taken");
        assert!(problem.contains("taken"), "{problem}");
        let left = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 2);
    }
}
