# Parts that are built where what they need is found. Their switches are AUTO until somebody sets them, so that every
# configuration looks again; ON: what is missing is an error; OFF: the part is left out.

function(declare_part switch what)
  set(${switch} AUTO CACHE STRING "${what}: ON, OFF, or AUTO, where what it needs is found")
  set_property(CACHE ${switch} PROPERTY STRINGS AUTO ON OFF)
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
