//! A robot belongs to one user: processes of another user get an error, and do not disturb it.
#![cfg(feature = "command")]

// Some of it is for other tests.
#[allow(dead_code)]
mod common;

use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::os::unix::process::CommandExt as _;
use std::process::Command;

use common::stage::{SENTENCE, Stage};
use common::{done, refused};
use nsrm_ipc::message::Role;
use nsrm_tests::isolated_memory::join;

/// User and group `nobody`, on Debian and most others.
const OTHER: u32 = 65534;

#[test]
#[ignore = "needs root, for a second user; run by cargo verify"]
fn a_second_user_is_refused_and_disturbs_nothing() {
    let mut stage = Stage::new("second-user");
    let user = std::fs::metadata(stage.bench.folder.path()).unwrap().uid();
    assert_eq!(user, 0, "only root can start processes as another user");
    stage.open_to_all();
    // Anyone may write there; this file looks as if it were still being created, for ever.
    let foreign = format!("/dev/shm/{}x.connection", stage.memory.prefix());
    let mut touch = Command::new("touch");
    let touched = touch.arg(&foreign).uid(OTHER).gid(OTHER).status();
    assert!(touched.unwrap().success());
    let robot = join("left", Role::Watcher, &stage.memory.config);
    // The simulated world may be creating its own segments meanwhile.
    while !robot.cleanup_dead_nodes() {
        std::thread::yield_now();
    }
    assert!(std::fs::exists(&foreign).unwrap());
    std::fs::remove_file(foreign).unwrap();
    drop(robot);
    stage.start("perceive", "perceiving");
    stage.start("serve", "planning");
    for arguments in [
        &["say", SENTENCE][..],
        &["say", SENTENCE, "--plan-only"],
        &["watch", "--once"],
        &["perceive"],
        &["serve"],
    ] {
        let mut command = stage.command(arguments);
        let ended = command.uid(OTHER).gid(OTHER).output().unwrap();
        let message = "belongs to another user; start all processes as that user";
        refused(
            &ended,
            &["robot `left`: the shared-memory folder ", message],
        );
    }
    for name in stage.memory.left_behind() {
        // A file that is just being removed has no owner.
        let owner = std::fs::metadata(format!("/dev/shm/{name}")).map_or(user, |it| it.uid());
        assert_eq!(owner, user, "{name}");
    }
    let said = done(&stage.say(&[SENTENCE]));
    assert!(said.ends_with("\ndone\n"), "{said}");
    for process in &mut stage.processes {
        assert!(process.try_wait().unwrap().is_none(), "it has ended");
    }
}

impl Stage {
    /// Lets other users read the folder with the configuration, and start the command from there:
    /// they may have no access to the build folder.
    fn open_to_all(&mut self) {
        let path = self.bench.path("nsrm");
        std::fs::copy(&self.nsrm, &path).unwrap();
        let folder = self.bench.folder.path();
        for (name, mode) in [
            ("", 0o755),
            ("nsrm", 0o755),
            ("robot.toml", 0o644),
            ("model.safetensors", 0o644),
        ] {
            let permissions = Permissions::from_mode(mode);
            std::fs::set_permissions(folder.join(name), permissions).unwrap();
        }
        self.nsrm = path;
    }
}
