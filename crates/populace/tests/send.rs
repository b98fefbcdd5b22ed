//! A crowd, its changing view and the handles that users store can move to another thread.

use populace::{Crowd, CrowdBuilder, Device, Error, Event, MemberId, MemberMut, Watch};

fn is_send<T: Send>() {}

#[test]
fn crowd_view_and_handles_are_send() {
    is_send::<Crowd>();
    is_send::<CrowdBuilder>();
    is_send::<MemberMut<'_>>();
    is_send::<(Device, Error, Event, MemberId, Watch)>();
}

#[test]
fn crowd_updates_on_another_thread() {
    let builder = Crowd::builder().device(Device::Native { threads: 2 });
    let mut crowd = builder.build().expect("a crowd");
    let crowd = std::thread::spawn(move || {
        crowd.update(0.1).expect("an update");
        crowd
    });
    assert_eq!(crowd.join().expect("no panic").member_count(), 0);
}
