# shellcheck shell=bash disable=SC2034  # its variables are for the scripts that source it
# Sourced by the other scripts: where things are, and the environment that the package is built in.
# Nothing here installs, builds or prints.

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# Hidden from rospack by the leading dot: the repository is the package, and the build folder holds
# things that look like packages too.
build_folder="$repository/.build/release"
# Of builds for something else. Not below the repository: rosrun looks for programs in all of it, and
# would find two of each.
other_builds=${XDG_CACHE_HOME:-~/.cache}/bearing_calibration$repository
if [[ -n "${sanitize:-}" ]]; then build_folder="$other_builds/$sanitize"; fi
# Where ROS is not the distribution's own: ROS-O, or Noetic.
ros_setup=
for ros_name in noetic one; do
  if [[ -f "${ros_folder:=/opt/ros}/$ros_name/setup.bash" ]]; then
    ros_setup="$ros_folder/$ros_name/setup.bash"
  fi
done

say() { printf '\n== %s\n' "$*" >&2; }
fail() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }

# Clones share what the compiler has made: the path to them is no part of it.
export CCACHE_BASEDIR="$repository"

# ROS's own scripts start with `env python3` and need the system's interpreter.
export PATH="/usr/bin:/bin:/usr/sbin:/sbin:$PATH"
unset PYTHONHOME
export ROS_HOME="${ROS_HOME:-$repository/.build/ros}"
export ROS_LOG_DIR="${ROS_LOG_DIR:-$ROS_HOME/log}"
# Works without a network; left alone where somebody has set up a robot with several machines.
if [[ -z "${ROS_HOSTNAME:-}${ROS_IP:-}${ROS_MASTER_URI:-}" ]]; then
  export ROS_HOSTNAME=localhost
fi

# stampOf TARGET...: the file that is there once these targets have been built.
stampOf() {
  local name
  name="$(printf '%s\n' "$@" | cksum)"
  printf '%s/.built-%s' "$build_folder" "${name%% *}"
}

# configure SOURCE FOLDER OPTION...: by CMake. catkin takes a snapshot of the environment when it configures for
# the first time: what is not there yet is missing from PYTHONPATH and PKG_CONFIG_PATH for ever.
configure() {
  mkdir -p "$2/devel/lib/python3/dist-packages" "$2/devel/lib/pkgconfig"
  cmake -S "$1" -B "$2" "${@:3}" > "$2/configure.log" 2>&1 9>&- && return
  rm -f "$2/CMakeCache.txt"
  cat "$2/configure.log" >&2
  fail "configuring failed"
}

# takeTurn FOLDER: two that build, run and write there at once would spoil each other's: the second waits.
takeTurn() {
  mkdir -p "$1"
  exec 8> "$1.lock"
  flock --nonblock 8 || { say "Waiting for another ./scripts/${0##*/} in this clone"; flock 8; }
}

# makeRoot SUITE FOLDER: a bare Debian.
makeRoot() {
  [[ "$(id -u)" -eq 0 ]] || fail "debootstrap and chroot want root: use sudo"
  command -v debootstrap > /dev/null || fail "install it first: apt-get install debootstrap"
  debootstrap --variant=minbase "$1" "$2"
  cp /etc/resolv.conf "$2/etc/resolv.conf"
  echo "127.0.0.1 localhost" > "$2/etc/hosts"
}

# runInRoot FOLDER [VARIABLE=VALUE...] COMMAND...: there, with nothing of the environment here. What it
# mounts is seen by the command alone, and goes with it, also on ctrl-C.
runInRoot() {
  # shellcheck disable=SC2016  # to be expanded there
  unshare --mount sh -c 'mount -t proc proc "$0/proc" && mount -t devpts devpts "$0/dev/pts" &&
    exec chroot "$0" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root ROS_HOSTNAME=localhost "$@"' "$@"
}

# ROS's setup files read variables that are not set, and without --extend forget the workspace that the
# caller has sourced, with the messages of his robot.
source_setup() {
  set +u
  # shellcheck disable=SC1090
  CATKIN_SETUP_UTIL_ARGS=--extend source "$1"
  set -u
}

if [[ -n "$ros_setup" ]]; then source_setup "$ros_setup"; fi
