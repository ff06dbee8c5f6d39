# complete.zsh PROGRAM: types the beginnings of words into a shell of its own, presses the tabulator, and looks at what
# the completion of tanor offers there.
zmodload zsh/zpty || exit 1
program=$1
folder=$(mktemp -d)
trap 'rm -rf $folder' EXIT
cd $folder
touch net.json notes.txt
$program completion zsh > _tanor || exit 1

zpty shell zsh -f -i
zpty -w shell "cd $folder; PS1='>'; autoload -Uz compinit; compinit -u -D; source ./_tanor; zstyle ':completion:*' verbose yes; bindkey '^I' complete-word"

# What is shown within some seconds after keys were pressed.
press() {
  local shown= part
  zpty -n -w shell "$1"$'\t\t'
  for _ in {1..100}; do
    while zpty -rt shell part; do shown+=$part; done
    [[ $shown == *"$2"* ]] && return 0
    sleep 0.1
  done
  print -r -- "behind '$1' there is no '$2' in: $shown"
  return 1
}

failed=0
press 'tanor inf' 'tanor info' || failed=1
press $'\x15tanor run n' 'tanor run net.json' || failed=1
press $'\x15tanor run net.json --rep' '--report' || failed=1
press $'\x15tanor run net.json --method radau' 'radau5' || failed=1
zpty -d shell
exit $failed
