use super::*;

fn entry(folder: &Path) -> Entry {
    Cache::in_folder(folder).entry(["a device", "its source"].into_iter())
}

#[test]
fn binary_is_read_back_as_written() {
    let folder = tempfile::tempdir().unwrap();
    // The folder does not exist yet.
    let entry = entry(&folder.path().join("deep/er"));
    assert_eq!(entry.read(), None);
    for binary in [&b"binary"[..], b"a longer binary", b""] {
        entry.write(binary);
        assert_eq!(entry.read().as_deref(), Some(binary));
    }
    assert_eq!(fs::read_dir(folder.path().join("deep/er")).unwrap().count(), 1);
}

#[test]
fn entry_names_depend_on_every_word() {
    let cache = Cache::in_folder(Path::new("x"));
    let path = |words: &[&str]| cache.entry(words.iter().copied()).path;
    let all = [path(&["ab", "c"]), path(&["a", "bc"]), path(&["abc"]), path(&["ab", "c", ""])];
    for (place, one) in all.iter().enumerate() {
        assert!(!all[..place].contains(one), "{all:?}");
    }
    assert_eq!(path(&["ab", "c"]), all[0]);
}

#[test]
fn damaged_or_truncated_entry_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let entry = entry(folder.path());
    entry.write(b"binary");
    let whole = fs::read(&entry.path).unwrap();
    for length in [0, 1, HASH_BYTES, whole.len() - 1] {
        fs::write(&entry.path, &whole[..length]).unwrap();
        assert_eq!(entry.read(), None, "cut to {length} bytes");
    }
    for place in [0, HASH_BYTES, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[place] ^= 1;
        fs::write(&entry.path, damaged).unwrap();
        assert_eq!(entry.read(), None, "damaged at byte {place}");
    }
    entry.write(b"binary");
    assert_eq!(entry.read().as_deref(), Some(&b"binary"[..]));
}

#[test]
fn unwritable_folder_is_not_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a file");
    fs::write(&file, "kept").unwrap();
    let entry = entry(&file);
    entry.write(b"binary");
    assert_eq!(entry.read(), None);
    assert_eq!(fs::read(&file).unwrap(), b"kept");
}

#[test]
fn old_entries_are_deleted_and_other_files_stay() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let old = "0123456789abcdef0123456789abcdef.program";
    let names = [old, "old.txt", "old.program", "new.program"];
    for name in names {
        fs::write(at(name), name).unwrap();
    }
    let long_ago = SystemTime::now() - 2 * KEPT_FOR;
    for old in &names[..3] {
        File::options().append(true).open(at(old)).unwrap().set_modified(long_ago).unwrap();
    }
    entry(folder.path()).write(b"binary");
    assert_eq!(names.map(|name| at(name).exists()), [false, true, true, true]);
}

#[test]
fn reading_an_entry_renews_it() {
    let folder = tempfile::tempdir().unwrap();
    let entry = entry(folder.path());
    entry.write(b"binary");
    let long_ago = SystemTime::now() - 2 * KEPT_FOR;
    File::options().append(true).open(&entry.path).unwrap().set_modified(long_ago).unwrap();
    assert!(entry.read().is_some());
    entry.delete_unused_beside();
    assert!(entry.read().is_some());
}
