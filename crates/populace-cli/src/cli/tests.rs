use super::*;

#[test]
fn command_line_is_consistent() {
    command().debug_assert();
}

/// Command lines, one argument in a line.
const LINES: [&str; 12] = [
    "demo\n--members\n200\n--frames\n60..61\n--out\nstreet.png",
    "render\n@people\n--members\n1000\n--size\n1280x720\n--out\np.png\n--json\n--detail\n0.5",
    "render\nknight.glb\n--clip\nwalk\n--root-motion\n--camera\ntop\n--out\nk.png",
    "render\nk.glb\n--device\nnative:2+opencl:0\n--split\n0.3,0.7\n--out\nk.png",
    "render\nscene.toml\n--camera\n1,2,3,0,1,0\n--out\nfilm.mp4\n--fps\n24\n--shutter\n180",
    "render\nwalk.txt\n--format\npetrack\n--data-fps\n2.5\n--trails\n3\n--out\nw.gif",
    "plan\nscene.toml\n--chunk\n100",
    "inspect\nwalk.txt\n--unit\ncm\n--heading\nmotion\n--json",
    "pose\nk.glb\n--slot\nclip=walk,time=0.5,layer=1\n--layer\n1,mask=spine,additive\n\
     --look-at\n1,2,-3\n--reach\nhand=1,2,3\n--json",
    "devices\n--json",
    "cast\n--from\nanny.whl\n--count\n3\n--seed\n7",
    "film\nframes\n--out\nfilm.mp4\n--fps\n24",
];

#[test]
fn seeds_of_command_lines_are_parsed() {
    for (nth, line) in LINES.into_iter().enumerate() {
        crate::fuzz_seeds::write("command_lines", &nth.to_string(), line.as_bytes());
        assert_eq!(crate::check_command_line(line.lines()), Ok(()), "{line}");
    }
}

#[cfg(not(feature = "bench"))]
#[test]
fn bench_takes_any_arguments_without_its_feature() {
    for args in [&["populace", "bench"][..], &["populace", "bench", "--help", "--members=5", "x"]] {
        assert!(matches!(Cli::parse_from(args).command, Command::Bench(_)), "{args:?}");
    }
}
