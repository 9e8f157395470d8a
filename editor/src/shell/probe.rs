//! Test whether a window can be opened, before anything that would end the program otherwise.

use bevy::tasks::block_on;

/// Graphics adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Name of the adapter.
    pub name: String,
    /// Whether it renders in software.
    pub software: bool,
}

/// Adapter that drawing would use.
///
/// # Errors
/// The reason why there is none, as part of a sentence.
pub fn adapter() -> Result<Adapter, String> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    // A missing driver is the result here, not a log message.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let found = block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let infos: Vec<wgpu::AdapterInfo> = found.iter().map(wgpu::Adapter::get_info).collect();
    let is_software = |i: &&wgpu::AdapterInfo| i.device_type == wgpu::DeviceType::Cpu;
    let best = infos.iter().find(|i| !is_software(i)).or_else(|| infos.first());
    match best {
        Some(info) => Ok(Adapter { name: info.name.clone(), software: is_software(&info) }),
        None => Err("no Vulkan driver was found".to_owned()),
    }
}

/// Adapter, if there is a display as well.
///
/// # Errors
/// The reason why a window is impossible, as part of a sentence.
pub fn window_possible() -> Result<Adapter, String> {
    display()?;
    adapter()
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn display() -> Result<(), String> {
    Ok(())
}

/// Check that an X server answers at DISPLAY. Windows use X11 here, under Wayland through XWayland.
#[cfg(all(unix, not(target_os = "macos")))]
fn display() -> Result<(), String> {
    let display = std::env::var("DISPLAY").unwrap_or_default();
    if display.is_empty() {
        return Err("there is no display (DISPLAY is not set)".to_owned());
    }
    if answers(&display) { Ok(()) } else { Err(format!("no display answers at DISPLAY={display}")) }
}

/// Whether the display `host:number.screen` accepts a connection. A number of another form counts
/// as accepted.
#[cfg(all(unix, not(target_os = "macos")))]
fn answers(display: &str) -> bool {
    use std::net::{TcpStream, ToSocketAddrs};
    use std::os::unix::net::UnixStream;
    use std::time::Duration;

    let Some((host, rest)) = display.rsplit_once(':') else { return false };
    let Ok(number) = rest.split('.').next().unwrap_or_default().parse::<u16>() else { return true };
    if host.is_empty() || host == "unix" {
        return UnixStream::connect(format!("/tmp/.X11-unix/X{number}")).is_ok() || abstract_socket(number);
    }
    let addresses = (host, 6000_u16.saturating_add(number)).to_socket_addrs();
    let mut addresses = addresses.into_iter().flatten();
    addresses.any(|a| TcpStream::connect_timeout(&a, Duration::from_secs(2)).is_ok())
}

#[cfg(target_os = "linux")]
fn abstract_socket(number: u16) -> bool {
    use std::os::linux::net::SocketAddrExt;
    use std::os::unix::net::{SocketAddr, UnixStream};

    let address = SocketAddr::from_abstract_name(format!("/tmp/.X11-unix/X{number}"));
    address.is_ok_and(|a| UnixStream::connect_addr(&a).is_ok())
}

#[cfg(all(unix, not(target_os = "macos"), not(target_os = "linux")))]
fn abstract_socket(_number: u16) -> bool {
    false
}

#[cfg(all(test, unix, not(target_os = "macos")))]
mod tests {
    use super::answers;

    #[test]
    fn a_display_that_is_not_there_does_not_answer() {
        assert!(!answers(":59873"));
        assert!(!answers("nonsense"));
        assert!(!answers("localhost:49999.0"));
    }
}
