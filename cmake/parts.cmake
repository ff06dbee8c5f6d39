# Parts that are built where what they need is found. Their switches are AUTO until somebody sets them, so that every
# configuration looks again; ON: what is missing is an error; OFF: the part is left out. With TANOR_AUTO=OFF only those
# are built that are ON, whatever is found.
option(TANOR_AUTO "Build what is AUTO where what it needs is found; OFF: packagers name what they want" ON)

function(declare_part switch what)
  set(${switch} AUTO CACHE STRING "${what}: ON, OFF, or AUTO, where what it needs is found")
  set_property(CACHE ${switch} PROPERTY STRINGS AUTO ON OFF)
  if(${switch} STREQUAL "AUTO" AND NOT TANOR_AUTO)
    set(${switch} OFF PARENT_SCOPE)
  endif()
endfunction()

# Sets <has> to whether the part is built. `obstacle` says what is missing, empty: nothing.
function(decide_part has switch obstacle)
  set(${has} OFF PARENT_SCOPE)
  if(NOT ${switch})
    message(STATUS "${switch}: left out")
  elseif(NOT obstacle)
    set(${has} ON PARENT_SCOPE)
  elseif(${switch} STREQUAL "AUTO")
    message(STATUS "${switch}: left out, ${obstacle}")
  else()
    message(FATAL_ERROR "${switch}: ${obstacle}")
  endif()
endfunction()

# A part of which all that is needed is found, or not: declares and decides it.
function(need_for has switch what missing)
  set(obstacle)
  foreach(found IN LISTS ARGN)
    if(NOT ${found})
      set(obstacle "${missing} is missing")
    endif()
  endforeach()
  declare_part(${switch} "${what}")
  decide_part(answer ${switch} "${obstacle}")
  set(${has} ${answer} PARENT_SCOPE)
  set(${switch} ${${switch}} PARENT_SCOPE)
endfunction()
