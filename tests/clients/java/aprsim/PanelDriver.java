package aprsim;

import aprs.conveyor.OuterConveyorSpeedControlJPanel;
import com.ghgande.j2mod.modbus.facade.ModbusTCPMaster;
import java.lang.reflect.Field;
import java.util.concurrent.TimeUnit;
import javax.swing.SwingUtilities;

/** The conveyor panel with j2mod, without a display. connect PORT; next; previous. The panel itself knows port 502 only, so its connection is put in. */
public final class PanelDriver {
  private static OuterConveyorSpeedControlJPanel panel;

  public static void main(String[] unused) throws Exception {
    SwingUtilities.invokeAndWait(() -> panel = new OuterConveyorSpeedControlJPanel());
    Console.serve(
        (command, arguments) -> {
          switch (command) {
            case "connect":
              ModbusTCPMaster master = new ModbusTCPMaster("127.0.0.1", Integer.parseInt(arguments[0]));
              master.connect();
              Field field = OuterConveyorSpeedControlJPanel.class.getDeclaredField("master");
              field.setAccessible(true);
              field.set(panel, master);
              panel.setSimulated(false);
              panel.setNextDelayMillis(500);
              return "true";
            case "next":
              panel.nextTray().get(60, TimeUnit.SECONDS);
              return String.valueOf(panel.getEstimatedPosition());
            case "previous":
              panel.prevTray().get(60, TimeUnit.SECONDS);
              return String.valueOf(panel.getEstimatedPosition());
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }
}
